"""Gamepads at other machines, over the bus: their presence and their reports.

No message is trusted: it is a valid state, or it is counted and dropped. Silence is an unplug.
"""

from __future__ import annotations

import dataclasses
import math
import threading
import time
from collections.abc import Callable

from hub.gcm.pad import ALIVE_HZ, DEVICE_HZ, OLDEST_S, PadDevice, PadState
from hub.values import dataclass
from rune_tui.controls.devices.device_reader import News, Opened, Refused, Scanned
from rune_tui.controls.devices.inbox import Inbox
from rune_tui.controls.devices.matching import DeviceInfo, plain_text
from rune_tui.controls.hid.device_controls import DeviceDecoder, PhysicalControl
from rune_tui.controls.remote_pad.pad_values import reports
from rune_tui.errors import DescriptorError
from rune_tui.model.joystick_state import Absence

IDLE_SILENCE_S = 5.0 / ALIVE_HZ
"""Longest silence of a pad that reported to be idle [s]."""
WAITING_SILENCE_S = 3.0 / DEVICE_HZ
"""Longest silence of a pad that reported to be unplugged [s]."""
MOST_PADS = 16
"""Largest number of pads; further ones are left out."""
LONGEST_DESCRIPTOR = 4096
"""Longest name, as in the kernel [bytes]."""
_CLOSE_S = 2.0

Sender = tuple[str, int]
"""The robot whose hub carries it, and the sender's number there."""


@dataclass(slots=True)
class _Pad:
    """A gamepad at another machine.

    Attributes:
        announced: Its newest announcement.
        heard: Time of that [s].
        info: The device.
        controls: Its controls; none: it is unusable, see `why`.
        here: Whether its states arrive.
        measured: Time of the newest state [s].
        active: Whether it is in use, and so sends its state all the time.
        absence: The reason why its states do not arrive, if they do not.
        absent: Time of the report of that [s].
        row: The newest numbers.
        inbox: Queue of its values; None: no joystick reads it.
    """

    announced: PadDevice
    heard: float
    info: DeviceInfo
    controls: tuple[PhysicalControl, ...]
    why: str
    here: bool = False
    measured: float = -math.inf
    active: bool = False
    absence: Absence = Absence.SILENT
    absent: float = -math.inf
    row: list[int] = dataclasses.field(default_factory=list)
    inbox: Inbox | None = None

    @property
    def silent_at(self) -> float:
        """Time at which it counts as unplugged, without a further message [s]."""
        return self.measured + (OLDEST_S if self.active else IDLE_SILENCE_S)


class FarPads:
    """The gamepads at the hubs of all robots of the console; links deliver their messages.

    Attributes:
        refused: Number of messages that were not valid.
        late: Number of states that were too old.
        operator: The operator of this console.
    """

    def __init__(self, operator: str = "", clock: Callable[[], float] = time.monotonic) -> None:
        """Prepare.

        Args:
            operator: The operator of this console; pads for others are ignored.
            clock: Monotonic time [s].
        """
        self.refused = self.late = 0
        self.operator = operator
        self._clock = clock
        self._notify: Callable[[], None] = lambda: None
        self._lock = threading.Lock()
        self._pads: dict[Sender, _Pad] = {}
        self._news: list[News] = []
        self._sooner, self._ended = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None

    def start(self, notify: Callable[[], None]) -> None:
        """Watch for silence from now on.

        Args:
            notify: Is called, in other threads, when there is something new.
        """
        self._notify = notify
        self._thread = threading.Thread(target=self._watch, name="rune-far-pads", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End."""
        self._ended.set()
        self._sooner.set()
        if self._thread is not None:
            self._thread.join(_CLOSE_S)

    def device_came(self, sender: Sender, announced: PadDevice) -> None:
        """Take an announcement of a gamepad."""
        with self._lock:
            known = self._pads.get(sender)
            if announced.operator not in {"", self.operator}:
                self._forget(sender)
            elif known is not None and _same(known.announced, announced):
                known.heard = self._clock()
            elif len(announced.descriptor) > LONGEST_DESCRIPTOR or not self._room(sender):
                self.refused += 1
            else:
                self._forget(sender)
                self._pads[sender] = described = self._described(sender, announced)
                if known is not None:
                    described.absence, described.absent = known.absence, known.absent
            fresh = bool(self._news)
        if fresh:
            self._notify()

    def state_came(self, sender: Sender, state: PadState, measured: float) -> None:
        """Take a state of a gamepad.

        Args:
            sender: Its sender.
            state: The state.
            measured: Its time, on this machine's clock [s].
        """
        with self._lock:
            fresh = self._follow(sender, state, measured)
        if fresh:
            self._notify()

    def news(self) -> list[News]:
        """The events since the last call, in order."""
        with self._lock:
            self._expire()
            news, self._news = self._news, []
        return news

    def read(self, device: DeviceInfo) -> None:
        """Begin to read a device; `Opened` or `Refused` follows."""
        with self._lock:
            pad = self._at(device.path)
            if pad is None or pad.inbox is not None:
                return
            if pad.why:
                self._news.append(Refused(device.path, pad.why, unsuitable=True))
            else:
                pad.inbox = Inbox(pad.controls)
                for values in reports(pad.controls, None, pad.row):
                    pad.inbox.put(values)
                self._news.append(Opened(device.path, pad.controls))
        self._notify()

    def stop(self, path: str) -> None:
        """Read a device no more."""
        with self._lock:
            if (pad := self._at(path)) is not None:
                pad.inbox = None

    def inbox(self, path: str) -> Inbox | None:
        """The new values of a device in use."""
        with self._lock:
            pad = self._at(path)
            return None if pad is None else pad.inbox

    def measured(self, path: str) -> float | None:
        """When the newest state of a device was measured [s]; None if it is not there."""
        with self._lock:
            pad = self._at(path)
            return None if pad is None else pad.measured

    def senders_read(self, robot: str) -> list[int]:
        """Numbers at a robot's hub of the senders whose devices are read."""
        with self._lock:
            return [
                sender[1]
                for sender, pad in self._pads.items()
                if sender[0] == robot and pad.inbox is not None
            ]

    def absence(self, path: str) -> Absence | None:
        """Why a device is absent; None: it is not known, or it is here."""
        with self._lock:
            pad = next((each for each in self._pads.values() if each.info.path == path), None)
            if pad is None or pad.here:
                return None
            waits = pad.absence is Absence.UNPLUGGED
            if waits and self._clock() - pad.absent > WAITING_SILENCE_S:
                return Absence.SILENT
            return pad.absence

    def _at(self, path: str) -> _Pad | None:
        return next((p for p in self._pads.values() if p.here and p.info.path == path), None)

    def _described(self, sender: Sender, announced: PadDevice) -> _Pad:
        controls: tuple[PhysicalControl, ...] = ()
        why = "it is no joystick"
        try:
            descriptor = announced.descriptor.tobytes()
            decoder = DeviceDecoder(
                descriptor, vid=announced.vid, pid=announced.pid, bus=announced.bus or 3
            )
        except DescriptorError as error:
            why = f"its report descriptor cannot be read: {error}"
        else:
            controls = decoder.controls
        info = DeviceInfo(
            path=f"pad {sender[0]} {sender[1]}",
            vid=announced.vid,
            pid=announced.pid,
            serial=plain_text(announced.serial),
            name=plain_text(announced.name),
            port=plain_text(announced.port),
            bus=announced.bus,
            machine=plain_text(announced.machine) or "another machine",
        )
        return _Pad(announced, self._clock(), info, controls, "" if controls else why)

    def _room(self, sender: Sender) -> bool:
        """Whether there is room for one more; the silent one with the oldest message makes room."""
        if sender in self._pads or len(self._pads) < MOST_PADS:
            return True
        silent = [other for other, pad in self._pads.items() if not pad.here]
        if silent:
            del self._pads[min(silent, key=lambda other: self._pads[other].heard)]
        return bool(silent)

    def _forget(self, sender: Sender) -> None:
        if (pad := self._pads.pop(sender, None)) is not None and pad.here:
            self._post_devices()

    def _follow(self, sender: Sender, state: PadState, measured: float) -> bool:
        """Apply a state; returns whether it changes anything."""
        self._expire()  # the silence before this state may not have been noticed
        pad, now = self._pads.get(sender), self._clock()
        if pad is None or state.session != pad.announced.session:
            return False  # it is for another console, or its device is unknown yet
        if not state.values.size:
            pad.absent = now
            return self._unplug(pad, Absence.UNPLUGGED if state.active else Absence.ENDED)
        if now - measured > OLDEST_S:
            self.late += 1
            return False
        if not pad.why and len(state.values) != len(pad.controls):
            self.refused += 1
            return False
        sooner = not pad.here or bool(state.active) != pad.active
        before, pad.row = pad.row, state.values.tolist()
        pad.measured, pad.active = min(measured, now), bool(state.active)
        if sooner:
            self._sooner.set()
        if not pad.here:
            pad.here = True
            self._post_devices()
            return True
        inbox = pad.inbox
        if inbox is None:
            return False
        return True in [inbox.put(values) for values in reports(pad.controls, before, pad.row)]

    def _unplug(self, pad: _Pad, absence: Absence = Absence.SILENT) -> bool:
        was_here, pad.here, pad.inbox = pad.here, False, None
        pad.absence = absence
        if was_here:
            self._post_devices()
        return was_here

    def _post_devices(self) -> None:
        self._news.append(Scanned(tuple(pad.info for pad in self._pads.values() if pad.here)))

    def _expire(self) -> float:
        """Unplug silent devices; returns the time until the next check [s]."""
        now, least = self._clock(), math.inf
        for pad in self._pads.values():
            if pad.here and now > pad.silent_at:
                self._unplug(pad)
            elif pad.here:
                least = min(least, pad.silent_at - now)
        return least

    def _watch(self) -> None:
        while not self._ended.is_set():
            with self._lock:
                left = self._expire()
                unreported = bool(self._news)
            if unreported:
                self._notify()
            self._sooner.wait(None if left == math.inf else left + 1e-3)
            self._sooner.clear()


def _same(one: PadDevice, other: PadDevice) -> bool:
    """Whether these are equal."""
    first, second = (
        {**dataclasses.asdict(each), "descriptor": each.descriptor.tobytes()}
        for each in (one, other)
    )
    return first == second
