"""A vehicle with a simulated autopilot, recorded as the other bodies of the stale-stick cases.

Commands are read where the vehicle receives them; what does not reach it is no command. The motion
is what the vehicle says to a station of its own, which outlives the hub and its driver.
"""

from __future__ import annotations

import contextlib
import itertools
import math
import select
import socket
import threading
import time
from pathlib import Path
from typing import Final

from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from tests.support.mavlink_numbers import BLIMP_VELOCITY, GUIDED, INTERVAL, POSITION_HOLD
from tests.support.mavlink_relay import MavlinkRelay, is_velocity, moves
from tests.system.autopilot_site import SimulatedVehicle, vehicle_tables
from tests.system.recorded_robot import Recording, Row

DOOR: Final = "autopilot-"
"""What the names of bodies begin with whose motors belong to an autopilot."""
AUTOPILOTS: Final = ("rover", "sub", "blimp")
PARAMETERS: Final = {
    "rover": ("SIM_RC_FAIL=1", "FS_TIMEOUT=0.1", "FS_GCS_ENABLE=1", "FS_GCS_TIMEOUT=2"),
    "sub": ("SIM_RC_FAIL=1", "FS_PILOT_INPUT=1", "FS_PILOT_TIMEOUT=0.5"),
    "blimp": ("SIM_RC_FAIL=1", "RC_OVERRIDE_TIME=0.5"),
}
"""Vehicles without a receiver, as companion computers have them."""
DRIVING_MODES: Final = {"rover": GUIDED, "sub": POSITION_HOLD, "blimp": BLIMP_VELOCITY}
_POSITION, _ATTITUDE = 32, 30
_EVERY_US: Final = 25_000.0
_PERIOD_S: Final = 0.03
_ENDS_S: Final = 0.2
"""A command counts for so long: a moving one is sent again after 50 ms [s]."""
_STILL: Final = 0.05
_STATION: Final = 254


class Station:
    """Another ground station at the vehicle: it watches, and gives orders.

    Attributes:
        motions: Monotonic time [s], speed [m/s] and turn rate [rad/s] of the vehicle.
        armed: Whether the vehicle is armed.
        mode: Number of its mode.
    """

    def __init__(self, port: int) -> None:
        self.motions: list[tuple[float, float, float]] = []
        self.armed, self.mode = False, -1
        self._port, self._packer = port, FramePacker(_STATION, 190)
        self._link: socket.socket | None = None
        self._speed = self._turn = 0.0
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="station")
        self._thread.start()

    def order(self, command: int, *values: float) -> None:
        """Send a command."""
        fields = {f"param{place}": value for place, value in enumerate(values, 1)}
        target = {"target_system": 1, "target_component": 1}
        packed = self._packer.pack("COMMAND_LONG", command=command, **fields, **target)
        if self._link is not None:
            self._link.sendall(packed)

    def move_to(self, port: int) -> None:
        """Watch the vehicle at another port."""
        self._port = port

    def close(self) -> None:
        self._ends = True
        self._thread.join()

    def _run(self) -> None:
        while not self._ends:
            with (
                contextlib.suppress(OSError),
                socket.create_connection(("127.0.0.1", self._port), 0.2) as link,
            ):
                self._link = link
                self._watch(link)
            self._link = None
            time.sleep(0.02)

    def _watch(self, link: socket.socket) -> None:
        for message in (_POSITION, _ATTITUDE):
            self.order(INTERVAL, message, _EVERY_US)
        parser = FrameParser()
        while not self._ends:
            if select.select([link], [], [], 0.05)[0]:
                data = link.recv(1 << 16)
                if not data:
                    return
                for frame in parser.feed(data):
                    self._take(frame)

    def _take(self, frame: MavlinkFrame) -> None:
        match frame.name:
            case "HEARTBEAT":
                self.armed, self.mode = bool(frame["base_mode"] & 128), frame["custom_mode"]
            case "ATTITUDE":
                self._turn = frame["yawspeed"]
            case "LOCAL_POSITION_NED":
                self._speed = math.hypot(frame["vx"], frame["vy"], frame["vz"])
                self.motions.append((time.monotonic(), self._speed, self._turn))


class RecordedAutopilot(Recording):
    """The commands that reach such a vehicle, and its motion.

    Attributes:
        kind: "rover", "sub" or "blimp".
        vehicle: The simulated vehicle.
        relay: Between it and the hub.
        station: Another ground station.
    """

    def __init__(self, folder: Path, body: str) -> None:
        del folder
        self.kind = body.removeprefix(DOOR)
        self.vehicle = SimulatedVehicle(self.kind, PARAMETERS[self.kind])
        self.relay = MavlinkRelay(self.vehicle.port)
        self.station = Station(self.vehicle.port)
        self._still = _STILL
        self._since = -math.inf
        self._cuts: list[tuple[float, float]] = []
        self.environment = {"PYTHONPATH": str(Path(__file__).parents[2])}
        self.hub = {"kind": "mavlink", "tables": vehicle_tables(self.kind, self.relay.port)}

    def rows(self) -> list[Row]:
        """All since `forget`; of the rows of one moment the last, as frames come together."""
        events = [(at, speed, turn, -1) for at, speed, turn in list(self.station.motions)]
        events = [each for each in events if each[0] >= self._since]
        events += [
            (at, 0.0, 0.0, int(moves(frame)))
            for at, of_hub, frame in list(self.relay.frames)
            if of_hub and at >= self._since and self._counts(frame) and not self._is_cut(at)
        ]
        rows = []
        moving_at = -math.inf
        speed = turn = 0.0
        events.sort(key=lambda each: each[0])  # frames of one moment stay in their order
        nexts = [*(each[0] for each in events[1:]), time.monotonic()]
        for (at, now_speed, now_turn, command), after in zip(events, nexts, strict=True):
            if command < 0:
                speed, turn = now_speed, now_turn
            elif command:
                moving_at = at
            else:
                moving_at = -math.inf
            wanted = float(at - moving_at < _ENDS_S)
            rows.append(Row(at, wanted, 0.0, 0.0, 0.0, speed, 0.0, 0.0, turn))
            if wanted and after - moving_at >= _ENDS_S:  # nothing came for so long
                rows.append(Row(moving_at + _ENDS_S, *(0.0,) * 4, speed, 0.0, 0.0, turn))
        rows = list({row.at: row for row in rows}.values())
        return rows or [Row(time.monotonic(), *(0.0,) * 8)]

    def cut(self, *ways: str) -> None:
        """Let no byte pass in these directions, `to_vehicle` and `to_hub`."""
        for way in ways:
            setattr(self.relay, way, False)
        if "to_vehicle" in ways:
            self._cuts.append((time.monotonic(), math.inf))

    def join(self) -> None:
        """Let all pass again."""
        if self._cuts:
            self._cuts[-1] = (self._cuts[-1][0], min(self._cuts[-1][1], time.monotonic()))
        self.relay.join()

    def start_vehicle_again(self) -> None:
        """Kill the autopilot's process, and start another one in its place."""
        self.vehicle.kill()
        self.vehicle = SimulatedVehicle(self.kind, PARAMETERS[self.kind])
        self.relay.vehicle = self.vehicle.port
        self.station.move_to(self.vehicle.port)

    def away(self, since: float, until: float) -> float:
        """For how long the machine was too busy for the vehicle [s]."""
        times = [at for at, *_ in list(self.station.motions) if since <= at <= until]
        pauses = [after - before for before, after in itertools.pairwise(times)]
        return sum(each - _PERIOD_S for each in pauses if each > 2.0 * _PERIOD_S)

    def forget(self) -> None:
        """All that is older than a second."""
        self._since = time.monotonic() - 1.0
        for kept in (self.station.motions, self.relay.frames):
            del kept[: sum(1 for each in kept if each[0] < self._since)]

    def close(self) -> None:
        self.station.close()
        self.relay.close()
        self.vehicle.close()

    def _counts(self, frame: MavlinkFrame) -> bool:
        """Whether a frame is a velocity; beside that of a rover go sticks that are neutral."""
        beside = self.kind == "rover" and frame.name == "MANUAL_CONTROL" and not moves(frame)
        return is_velocity(frame) and not beside

    def _is_cut(self, at: float) -> bool:
        return any(begun <= at < ended for begun, ended in self._cuts)
