"""What a vehicle with an autopilot costs the driver, and how soon a velocity is on the wire.

A hub with a driver drives a simulated rover over a relay, which notes each frame. This program is
its navigation. Then the driver's frames are read and written alone, beside pymavlink.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import psutil

from benchmarks.figures import median_ms, report, say
from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotPhase, AutopilotState
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import DRIVE_COMMAND
from hub.gcm.vehicle import VEHICLE_COMMAND, VehicleCommand, VehicleOrder
from hub.ipc.client import Client
from hub.robots.mavlink.profiles.profile import STREAMS
from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from tests.support.mavlink_relay import MavlinkRelay
from tests.support.waiting import until
from tests.system.autopilot_site import SimulatedVehicle, vehicle_tables
from tests.system.harness import HubProcess

_SECONDS = 20.0
_LEAST_HZ = 5.0
_COMMANDS = 200
_EVERY_S = 1.0 / DRIVE_COMMAND.rate_hz
_PARAMETERS = ("SIM_RC_FAIL=1", "FS_TIMEOUT=0.1")


class Drive:
    """This program as navigation and operator of a hub that has only a driver."""

    def __init__(self, hub: HubProcess, relay: MavlinkRelay) -> None:
        self.hub, self.relay = hub, relay
        self.client = Client("navigation", hub.endpoint)
        self.client.wait_connected(5.0)
        self.client.define(DRIVE_COMMAND, VEHICLE_COMMAND)
        self.client.wait_defined(5.0)
        self._state: AutopilotState | None = None
        self.client.subscribe(AUTOPILOT_STATE, lambda state, _: setattr(self, "_state", state))

    def begin(self) -> None:
        """Until it drives."""
        self._until(lambda: self._state and self._state.armable and self._state.position)
        self.client.publish(VEHICLE_COMMAND, VehicleCommand(order=VehicleOrder.ARM))
        self._until(lambda: self._state and self._state.phase is AutopilotPhase.DRIVING)
        packer = FramePacker(255, 190)
        for name, rate in STREAMS.items():
            values = {"param1": float(BY_NAME[name].number), "param2": 1e6 / max(rate, _LEAST_HZ)}
            target = {"target_system": 1, "target_component": 1}
            self.relay.add(packer.pack("COMMAND_LONG", command=511, **values, **target))

    def velocity(self, ahead: float) -> None:
        self.client.publish(DRIVE_COMMAND, TwistStamped.of(Twist.planar(ahead, 0.0)))

    def go_on(self, seconds: float, ahead: float) -> None:
        """Repeat a velocity at the rate of navigation."""
        due = time.monotonic()
        end = due + seconds
        while due < end:
            self.velocity(ahead)
            due += _EVERY_S
            while (left := min(due, end) - time.monotonic()) > 0.0:
                self.client.listen(left)

    def share(self, ahead: float) -> tuple[float, float]:
        """The driver's share of a core [%], and the frames that came [Hz]."""
        self.go_on(1.0, 0.0)
        self.go_on(1.0, ahead)
        driver = psutil.Process(self.hub.pids["driver"])
        before, begun, frames = driver.cpu_times(), time.monotonic(), len(self.relay.frames)
        self.go_on(_SECONDS, ahead)
        after, seconds = driver.cpu_times(), time.monotonic() - begun
        used = after.user + after.system - before.user - before.system
        came = sum(not of_hub for _, of_hub, _ in self.relay.frames[frames:])
        return 100.0 * used / seconds, came / seconds

    def delays(self) -> list[float]:
        """Times from publishing a velocity to its frame on the wire [s]."""
        found = []
        for count in range(_COMMANDS):
            self.go_on(_EVERY_S / 2, 0.1)
            ahead = 0.2 + count * 1e-3
            begun = time.monotonic()
            self.velocity(ahead)
            self._until(lambda ahead=ahead, begun=begun: self._on_wire(ahead, begun))
            found.append(self._on_wire(ahead, begun) - begun)
        return found

    def _on_wire(self, ahead: float, since: float) -> float:
        """When a velocity was on the wire; 0: it has not been yet."""
        name = "SET_POSITION_TARGET_LOCAL_NED"
        for at, frame in self.relay.of_hub(since, newest=20):
            if frame.name == name and abs(frame["vx"] - ahead) < 1e-6:
                return at
        return 0.0

    def _until(self, condition: Any) -> None:
        until(condition, 30.0, meanwhile=lambda: self.client.listen(0.0))


def drive() -> None:
    """Measure a drive."""
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(SimulatedVehicle("rover", _PARAMETERS)) as vehicle,
        closing(MavlinkRelay(vehicle.port)) as relay,
    ):
        tables = vehicle_tables("rover", relay.port)
        options = {"kind": "mavlink", "modules": ("driver",), "tables": tables}
        with closing(HubProcess(Path(folder), **options)) as hub:
            scene = Drive(hub, relay)
            with closing(scene.client):
                scene.begin()
                for what, ahead in (("that moves", 0.3), ("that stands", 0.0)):
                    share, rate = scene.share(ahead)
                    note = f"{len(STREAMS)} streams, {rate:.0f} frames/s, {what}"
                    report("mavlink_driver", share, "% of a core", bar=3.0, note=note)
                scene.go_on(0.5, 0.0)
                delays = sorted(scene.delays())
                note = f"the slowest of {len(delays)}: {delays[-1] * 1e3:.1f} ms"
                middle = statistics.median(delays) * 1e3
                report("mavlink_command_to_wire", middle, "ms", bar=2.0, note=note)


def frames() -> None:
    """Measure reading and writing of frames, beside pymavlink."""
    from pymavlink.dialects.v20 import ardupilotmega

    packer, parser = FramePacker(1, 1), FrameParser()
    attitude = {"time_boot_ms": 5, "roll": 0.1, "pitch": 0.2, "yaw": 0.3, "yawspeed": 0.1}
    data = b"".join(packer.pack("ATTITUDE", **attitude) for _ in range(100))
    theirs = ardupilotmega.MAVLink(None, 1, 1)
    theirs.robust_parsing = True
    message = ardupilotmega.MAVLink_attitude_message(5, 0.1, 0.2, 0.3, 0.0, 0.0, 0.1)

    def microseconds(work: Any) -> float:
        return median_ms(lambda _: work(), 200, clock=time.thread_time) * 1e3 / 100.0

    report(
        "mavlink_read",
        microseconds(lambda: parser.feed(data)),
        "us a frame",
        peers={"pymavlink": microseconds(lambda: theirs.parse_buffer(data))},
    )
    report(
        "mavlink_write",
        microseconds(lambda: [packer.pack("ATTITUDE", **attitude) for _ in range(100)]),
        "us a frame",
        peers={"pymavlink": microseconds(lambda: [message.pack(theirs) for _ in range(100)])},
    )


def main() -> None:
    """Measure both."""
    frames()
    say("driving takes a minute")
    drive()


if __name__ == "__main__":
    main()
