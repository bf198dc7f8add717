"""The queue in front of a client's sockets: messages of a burst leave it together.

| a message | leaves |
| --- | --- |
| alone, or one of two | at once |
| in a burst | with the next ones, when enough wait or the module listens |
| in a burst, while the module is busy | after `WAIT_S`, by a thread of the queue |

The lock of the queue also guards the sockets behind it, because two threads send.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.ipc.definition import Plane
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames

WAIT_S = 0.5e-3
"""Longest wait of a message in a burst while its module is busy [s]."""

Send = Callable[[bytes, int], Any]
"""Sends a frame to one subscriber; the number is of flags."""
Combine = Callable[[int, Sequence[bytes]], tuple[bytes, tuple[Send, ...], bytes, Plane]]
"""(number of the first message, messages) -> one frame for them, the subscribers on this machine
that get it, its topic for all others (empty: none), and its plane."""


class SendQueue:
    """Sends the frames of one client, in the order in which they were published.

    Attributes:
        lock: Guards the queue and the sockets.
        topics: Topics with subscribers at central.
        last: Time of the last message, waiting or sent [s].
        second_last: The time of the message before it [s]. A burst begins with its third message:
            for two, a batch costs more than it saves.
        latest: Its publisher. The next message of another publisher has a frame of its own: that
            is cheaper than a batch of one.
    """

    def __init__(
        self, send_to_central: Callable[[bytes, bytes, Plane], None], faults: FaultCounter
    ) -> None:
        """Start empty.

        Args:
            send_to_central: Sends a frame under a topic on a plane.
            faults: Counts unsent messages.
        """
        self.lock = threading.Lock()
        self.topics: set[bytes] = set()
        self.last = 0.0
        self.second_last = 0.0
        self.latest: object = None
        self._send_to_central = send_to_central
        self._faults = faults
        # Each: how to combine, the number of the first (0: a whole frame), the messages.
        self._runs: list[tuple[Combine, int, list[bytes]]] = []
        # Messages of the last run, if more can still join it.
        self._last_combine: Combine | None = None
        self._last_messages: list[bytes] = []
        self._count = 0
        self._since = 0.0
        self._wake = threading.Event()
        self._woken = False
        self._closed = False
        self._thread: threading.Thread | None = None

    @property
    def pending(self) -> bool:
        """Whether messages wait."""
        return bool(self._runs)

    def send(self, frame: bytes, direct: tuple[Send, ...], topic: bytes, plane: Plane) -> None:
        """Send a frame at once, behind all waiting messages.

        Args:
            frame: The frame.
            direct: The subscribers on this machine that get it.
            topic: For all other subscribers; empty: none.
            plane: Its plane.
        """
        with self.lock:
            if self._runs:
                self._send_waiting()
            for send in direct:
                self._send_directly(send, frame)
            if topic in self.topics:
                self._send_to_central(frame, topic, plane)

    def add(self, combine: Combine, number: int, message: bytes, now: float, limit: int) -> None:
        """Keep a message of a burst, to send it with more.

        Args:
            combine: Makes one frame of consecutive messages of the same publisher.
            number: Its sequence number; 0 if the message is a whole frame.
            message: The message.
            now: The time [s].
            limit: Number of waiting messages at which all are sent.
        """
        with self.lock:
            if number and combine is self._last_combine:
                self._last_messages.append(message)
            else:
                if not self._runs:
                    self._since = now
                    if not self._woken:
                        self._wake_thread()
                self._last_messages = [message]
                self._runs.append((combine, number, self._last_messages))
                self._last_combine = combine if number else None
            self._count += 1
            if self._count >= limit or now - self._since > WAIT_S:
                self._send_waiting()

    def flush(self) -> None:
        """Send all waiting messages; any thread may call this."""
        with self.lock:
            self.flush_locked()

    def flush_locked(self) -> None:
        """Send all waiting messages; the caller holds the lock."""
        if self._runs:
            self._send_waiting()

    def clear_locked(self) -> None:
        """Forget all waiting messages; the caller holds the lock."""
        self._runs.clear()
        self._count = 0
        self._last_combine = None

    def close(self) -> None:
        """Send all waiting messages, and end the thread."""
        self.flush()
        self._closed = True
        self._wake.set()
        if self._thread is not None:
            self._thread.join()

    def _send_waiting(self) -> None:
        runs, self._runs, self._count = self._runs, [], 0
        self._last_combine = None
        bundles: dict[Send, list[bytes]] = {}
        before: tuple[Send, ...] = ()
        open_bundles: list[list[bytes]] = []
        for combine, number, messages in runs:
            frame, direct, topic, plane = combine(number, messages)
            if direct is not before:
                before, open_bundles = direct, [bundles.setdefault(send, []) for send in direct]
            for bundle in open_bundles:
                bundle.append(frame)
            if topic in self.topics:
                self._send_to_central(frame, topic, plane)
        for send, whole in bundles.items():
            self._send_directly(send, whole[0] if len(whole) == 1 else frames.bundle(whole))

    def _send_directly(self, send: Send, frame: bytes) -> None:
        try:
            send(frame, sockets.NOBLOCK)
        except zmq.Again:
            self._faults.count("queue full", "a subscriber on this machine is behind")

    def _wake_thread(self) -> None:
        self._woken = True
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="rune-flush", daemon=True)
            self._thread.start()
        self._wake.set()

    def _run(self) -> None:
        while not self._closed:
            self._wake.wait()
            self._wake.clear()
            time.sleep(WAIT_S)
            self._woken = False  # before the flush: a message from now on wakes the thread again
            self.flush()
