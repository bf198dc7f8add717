"""What the door to Foxglove costs beside a hub, and how long messages take through it."""

from __future__ import annotations

import statistics
import struct
import tempfile
import time
from contextlib import closing
from pathlib import Path

import psutil

from benchmarks.figures import report
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import DRIVE_STATE, VELOCITY_COMMAND
from hub.ipc.client import Client
from tests.support.foxglove_panel import DoorProcess, Panels
from tests.system.harness import HubProcess

_SECONDS = 12.0
_PRESSES = 20
_STATE = (
    *("/odom", "/tf", "/scan", "/battery_state", "/diagnostics", "/rosout"),
    *(f"/rune/{name}" for name in ("GCM_RobotState", "GCM_CameraState", "GCM_DriveState")),
    "/rune/SIM_GroundTruth",
)
_SCENE = ("/camera/camera/image/compressed", "/camera/camera/camera_info", "/map", "/rune/marks",
          "/tf_static")  # fmt: skip


def share(door: DoorProcess, panels: Panels) -> tuple[float, float, float]:
    """The door's share of a core [%], messages [Hz] and bytes a second."""
    process = psutil.Process(door.process.pid)
    panels.pump(2.0)
    panels.payloads.clear()
    before, begun = process.cpu_times(), time.monotonic()
    panels.pump(_SECONDS)
    after, seconds = process.cpu_times(), time.monotonic() - begun
    used = after.user + after.system - before.user - before.system
    came = [payload for each in panels.payloads.values() for payload in each]
    return 100.0 * used / seconds, len(came) / seconds, sum(map(len, came)) / seconds


def costs(door: DoorProcess, panels: Panels) -> None:
    """Measure the processor without panels, with states, and with all that a layout shows."""
    panels.pump(1.0)
    idle, _, _ = share(door, panels)
    report("foxglove.idle_cpu_percent", idle, "% of a core", bar=1.0, note="no panel")
    panels.show(*_STATE)
    used, rate, _ = share(door, panels)
    note = f"{rate:.0f} messages/s"
    report("foxglove.cpu_percent", used, "% of a core", bar=3.0, note=note)
    panels.show(*_SCENE)
    used, rate, size = share(door, panels)
    note = f"{rate:.0f} messages/s with pictures and map, {size / 1e3:.0f} kB/s"
    report("foxglove.scene_cpu_percent", used, "% of a core", bar=6.0, note=note)


def age(panels: Panels) -> None:
    """Measure how old a message is when a panel gets it."""
    topic = f"/rune/{DRIVE_STATE.name}"
    panels.hide(*_SCENE)
    ages = []
    end = time.monotonic() + _SECONDS
    while time.monotonic() < end:
        panels.stamps.clear()
        panels.pump(0.001)
        ages += [time.time_ns() - each for each in panels.stamps[topic]]
    report("foxglove.age_ms", statistics.median(ages) / 1e6, "ms", bar=20.0, note=topic)


def press(hub: HubProcess, panels: Panels) -> None:
    """Measure the time from a panel's velocity to the hub's, while the panel has control."""
    seen: list[float] = []
    with closing(Client("hand", hub.endpoint)) as client:
        client.wait_connected(5.0)

        def note(command: TwistStamped, _: object) -> None:
            seen.append(command.twist.linear.x)

        client.subscribe(VELOCITY_COMMAND, note)
        panels.teleop(encoding="cdr", kind="geometry_msgs/msg/Twist")
        found = []
        for count in range(10 + _PRESSES):
            ahead = 0.01 + count * 1e-4
            begun = time.monotonic()
            panels.send(struct.pack("<I6d", 0x100, ahead, 0, 0, 0, 0, 0))
            while time.monotonic() - begun < 0.1:
                client.listen(0.001)
                if ahead in seen:
                    found.append(time.monotonic() - begun)
                    seen.clear()
            panels.pump(0.001)
    middle = statistics.median(found) * 1e3 if found else None
    report("foxglove.press_ms", middle, "ms", bar=5.0, note=f"{len(found)} velocities")


def main() -> None:
    """Measure all beside a simulated robot."""
    with tempfile.TemporaryDirectory() as folder:
        modules = ("driver", "navigation", "vision", "mapping")
        with (
            closing(HubProcess(Path(folder), modules=modules)) as hub,
            closing(DoorProcess(hub.endpoint, "--drive")) as door,
            closing(Panels(door.address)) as panels,
        ):
            costs(door, panels)
            age(panels)
            press(hub, panels)


if __name__ == "__main__":
    main()
