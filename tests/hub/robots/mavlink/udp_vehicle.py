"""A vehicle that a test plays itself, over UDP on loopback."""

from __future__ import annotations

import contextlib
import socket
from typing import Any

from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from tests.support.mavlink_numbers import HOLD, ROVER

ARMED = 128
_READ_S = 5.0


class UdpVehicle:
    """Answers questions as an autopilot does; the test says the rest.

    Attributes:
        mode: Its mode; it accepts each other one.
        armed: Whether it is armed; it accepts that too.
        parameters: Those that it has.
        received: All frames that came, oldest first.
        deaf: Whether it throws away what comes.
    """

    def __init__(self, kind: int = ROVER, mode: int = HOLD) -> None:
        self.kind, self.mode, self.armed, self.deaf = kind, mode, False, False
        self.parameters: dict[str, float] = {"MAV_GCS_SYSID": 255.0}
        self.received: list[MavlinkFrame] = []
        self.boot_ms = 60_000
        self._socket = socket.socket(type=socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.0)
        self._peer: Any = None
        self._packer, self._parser = FramePacker(1, 1), FrameParser()

    @property
    def address(self) -> str:
        """For a robot file."""
        return f"udp://127.0.0.1:{self._socket.getsockname()[1]}"

    def close(self) -> None:
        self._socket.close()

    def send(self, name: str, **fields: object) -> None:
        if self._peer is not None:
            self._socket.sendto(self._packer.pack(name, **fields), self._peer)

    def heartbeat(self, status: int = 3) -> None:
        self.send(
            "HEARTBEAT",
            type=self.kind,
            autopilot=3,
            base_mode=1 | (ARMED if self.armed else 0),
            custom_mode=self.mode,
            system_status=status,
            mavlink_version=3,
        )

    def attitude(self, yaw: float = 0.0) -> None:
        self.boot_ms += 50
        self.send("ATTITUDE", time_boot_ms=self.boot_ms, yaw=yaw)

    def place(self, north: float, east: float, down: float = 0.0, **fields: float) -> None:
        self.send("EKF_STATUS_REPORT", flags=831)
        position = {"x": north, "y": east, "z": down, **fields}
        self.send("LOCAL_POSITION_NED", time_boot_ms=self.boot_ms, **position)

    def text(self, words: str, severity: int = 6) -> None:
        self.send("STATUSTEXT", severity=severity, text=words)

    def answer(self) -> list[MavlinkFrame]:
        """Read what came, and answer it; returns the frames."""
        came: list[MavlinkFrame] = []
        with contextlib.suppress(BlockingIOError):
            while True:
                data, self._peer = self._socket.recvfrom(65536)
                came += [] if self.deaf else self._parser.datagram(data)
        for frame in came:
            self._answer(frame)
        self.received += came
        return came

    def _answer(self, frame: MavlinkFrame) -> None:
        if frame.name == "TIMESYNC":
            self.send("TIMESYNC", tc1=1, ts1=frame["ts1"])
        elif frame.name == "PARAM_REQUEST_READ" and frame["param_id"] in self.parameters:
            name = frame["param_id"]
            self.send("PARAM_VALUE", param_id=name, param_value=self.parameters[name])
        elif frame.name == "COMMAND_LONG":
            if frame["command"] == 176:
                self.mode = int(frame["param2"])
            elif frame["command"] == 400:
                self.armed = bool(frame["param1"])
            target = {"target_system": frame.system, "target_component": frame.component}
            self.send("COMMAND_ACK", command=frame["command"], result=0, **target)

    def velocities(self) -> list[float]:
        """The velocities ahead that came, oldest first."""
        name = "SET_POSITION_TARGET_LOCAL_NED"
        assert name in BY_NAME
        return [frame["vx"] for frame in self.received if frame.name == name]
