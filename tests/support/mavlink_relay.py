"""A relay between a hub and a vehicle: it sees all frames, and cuts the link at a test's word."""

from __future__ import annotations

import contextlib
import math
import random
import selectors
import socket
import threading
import time
from typing import Final

from hub.robots.mavlink.wire.frames import FrameParser, MavlinkFrame

_AT_ONCE: Final = 65536
_NEUTRAL: Final[dict[str, dict[str, tuple[float, ...]]]] = {
    "MANUAL_CONTROL": {"x": (0,), "y": (0,), "z": (0, 500), "r": (0,)},
    "SET_POSITION_TARGET_LOCAL_NED": dict.fromkeys(("vx", "vy", "vz", "yaw_rate"), (0.0,)),
    "RC_CHANNELS_OVERRIDE": {f"chan{n}_raw": (1500, 65535, 0) for n in range(1, 9)},
}


def is_velocity(frame: MavlinkFrame) -> bool:
    """Whether a frame is a velocity or sticks, also neutral ones."""
    return frame.name in _NEUTRAL


def moves(frame: MavlinkFrame) -> bool:
    """Whether a frame asks for motion."""
    rests = _NEUTRAL.get(frame.name, {})
    return any(frame[field] not in values for field, values in rests.items())


class MavlinkRelay:
    """Takes the hub's connection, and makes one to the vehicle for each.

    Attributes:
        vehicle: TCP port of the vehicle on loopback.
        port: Its own, for the hub.
        to_vehicle: Whether bytes pass to the vehicle.
        to_hub: Whether bytes pass to the hub.
        loss: Share of the frames that are lost, each way.
        frames: All frames that came to it: monotonic time [s], whether of the hub, frame.
    """

    def __init__(self, vehicle: int) -> None:
        self.vehicle = vehicle
        self.to_vehicle = self.to_hub = True
        self.loss, self._chance = 0.0, random.Random(1)
        self.frames: list[tuple[float, bool, MavlinkFrame]] = []
        self._vehicle: socket.socket | None = None
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ, None)
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="relay")
        self._thread.start()

    def close(self) -> None:
        self._ends = True
        self._thread.join()

    def cut(self) -> None:
        """Let no byte pass."""
        self.to_vehicle = self.to_hub = False

    def join(self) -> None:
        """Let all bytes pass again."""
        self.to_vehicle = self.to_hub = True

    def add(self, frame: bytes) -> None:
        """Send a frame to the vehicle, as if it were the hub's."""
        assert self._vehicle is not None
        self._vehicle.sendall(frame)

    def of_hub(self, since: float, newest: int = 0) -> list[tuple[float, MavlinkFrame]]:
        """The velocities and sticks of the hub from a monotonic time [s] on.

        Args:
            since: The time.
            newest: How many of the newest frames to look at; 0: all.
        """
        return [
            (time, frame)
            for time, hub, frame in self.frames[-newest:]
            if hub and time >= since and is_velocity(frame)
        ]

    def moving(self, since: float) -> list[tuple[float, MavlinkFrame]]:
        """Those of them that ask for motion."""
        return [(time, frame) for time, frame in self.of_hub(since) if moves(frame)]

    def orders(self, since: float) -> list[tuple[int, float, float]]:
        """Number and first two parameters of the orders to arm and to change the mode."""
        return [
            (frame["command"], frame["param1"], frame["param2"])
            for time, hub, frame in list(self.frames)
            if hub and time >= since and frame.name == "COMMAND_LONG"
            if frame["command"] in (176, 400)
        ]

    def speeds(self, since: float) -> list[tuple[float, float]]:
        """The vehicle's speeds as it reported them: monotonic time [s], speed [m/s]."""
        return [
            (time, math.hypot(frame["vx"], frame["vy"], frame["vz"]))
            for time, hub, frame in list(self.frames)
            if not hub and time >= since and frame.name == "LOCAL_POSITION_NED"
        ]

    def _run(self) -> None:
        while not self._ends:
            for key, _ in self._selector.select(0.05):
                if key.data is None:
                    self._accept()
                elif key.data[0].fileno() >= 0:  # not closed with the other end just now
                    self._pass(key.data)
        for key in list(self._selector.get_map().values()):
            assert isinstance(key.fileobj, socket.socket)
            key.fileobj.close()
        self._selector.close()

    def _accept(self) -> None:
        hub, _ = self._listener.accept()
        try:
            vehicle = socket.create_connection(("127.0.0.1", self.vehicle), 1.0)
        except OSError:
            hub.close()
            return
        self._vehicle = vehicle
        for one, other, of_hub in ((hub, vehicle, True), (vehicle, hub, False)):
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            data = (one, other, of_hub, FrameParser())
            self._selector.register(one, selectors.EVENT_READ, data)

    def _pass(self, way: tuple[socket.socket, socket.socket, bool, FrameParser]) -> None:
        one, other, of_hub, parser = way
        data = b""
        with contextlib.suppress(OSError):
            data = one.recv(_AT_ONCE)
        if not data:
            for each in (one, other):
                self._selector.unregister(each)
                each.close()
            return
        now = time.monotonic()
        frames = parser.feed(data)
        self.frames += [(now, of_hub, frame) for frame in frames]
        if self.loss:
            data = b"".join(each.raw for each in frames if self._chance.random() >= self.loss)
        if self.to_vehicle if of_hub else self.to_hub:
            with contextlib.suppress(OSError):
                other.sendall(data)
