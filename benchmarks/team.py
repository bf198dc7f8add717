"""What a team of three robots costs, and how soon a chosen robot's picture is there.

Real processes: the hubs of a rover, a blimp and an underwater robot in the arena `hall`. A client
asks each for 15 pictures a second of 160x120 pixels, coded as for a console on a fast link. It
drives the rover; the others hold.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from pathlib import Path

import psutil

from benchmarks.figures import median_ms, report, say
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.gcm.vision import IMAGE, IMAGE_REQUEST, ImageCoding, ImageRequest
from hub.ipc.client import Client
from hub.modules.vision.coding import code
from hub.sim.arena import load_arena
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.camera.view import View
from tests.system.harness import HubProcess
from tests.system.team_operator import TEAM, Operator, run_team, team_hubs

REQUEST = ImageRequest(width_px=160, height_px=120, quality=60, coding=ImageCoding.RLE)
RATE = 15.0
WARM_S, MEASURED_S = 3.0, 15.0
COMMANDS_PER_S = 10.0
CHOICES = 12
LARGE_PX = 80
_CASTER = RayCaster(load_arena("hall"))


class Viewer:
    """Asks one robot for pictures, and turns it slowly if it is the one that is driven."""

    def __init__(self, hub: HubProcess, *, drives: bool) -> None:
        self.client = Client("viewer", hub.endpoint)
        self.client.wait_connected(10.0)
        self.pictures = 0
        self.client.every(1.0 / RATE, self._ask)
        if drives:
            self.client.every(1.0 / COMMANDS_PER_S, self._drive)
        self._began = time.monotonic()

    def _ask(self) -> None:
        self.client.query_notify(
            IMAGE_REQUEST,
            REQUEST,
            IMAGE,
            timeout=1.0,
            answered=lambda _, __: self._count(),
            failed=lambda error: say(str(error)),
        )

    def _count(self) -> None:
        self.pictures += 1

    def _drive(self) -> None:
        moves = time.monotonic() - self._began > 1.0  # the first commands must be neutral
        twist = Twist.planar(0.0, 0.3 if moves else 0.0)
        self.client.publish(VELOCITY_COMMAND, TwistStamped(twist=twist))


def spent(processes: Sequence[psutil.Process]) -> dict[str, float]:
    """Processor time of each process [s]."""
    used = {}
    for number, process in enumerate(processes):
        times = process.cpu_times()
        used[f"{number} {process.name()}"] = times.user + times.system
    return used


def cost() -> None:
    """All processes of the three hubs."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        hubs = stack.enter_context(team_hubs(Path(folder)))
        viewers = [Viewer(hub, drives=hub is hubs[0]) for hub in hubs]
        for viewer in viewers:
            stack.enter_context(closing(viewer.client))
        processes = [
            each
            for hub in hubs
            for top in [psutil.Process(hub.process.pid)]
            for each in (top, *top.children(recursive=True))
        ]

        def serve(seconds: float) -> None:
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                for viewer in viewers:
                    viewer.client.listen(0.005)

        serve(WARM_S)
        before, pictures = spent(processes), [viewer.pictures for viewer in viewers]
        began = time.monotonic()
        serve(MEASURED_S)
        took = time.monotonic() - began
        after = spent(processes)
    rates = [(v.pictures - n) / took for v, n in zip(viewers, pictures, strict=True)]
    shares = {name: (after[name] - before[name]) / took for name in before}
    for name, share in sorted(shares.items(), key=lambda each: -each[1])[:14]:
        say(f"{name}: {share:.3f}")
    alone = median_ms(lambda _: picture(), 100, clock=time.thread_time)
    note = f"{', '.join(f'{rate:.1f}' for rate in rates)} pictures/s, {len(processes)} processes; "
    note += f"the machine draws and codes such a picture alone in {alone:.1f} ms, 2.2 if it is idle"
    report("team.hubs_core", sum(shares.values()), "of a core", bar=0.3, note=note)


def picture() -> None:
    """Draw and code a picture under water, to see how busy the machine is."""
    view = View(x=9.0, y=5.6, z=0.8, yaw=1.0, pitch=0.01, roll=0.01, horizontal_fov=1.4)
    pixels = _CASTER.picture(view, REQUEST.width_px, REQUEST.height_px)
    code(pixels, REQUEST.coding, REQUEST.quality)


def choice() -> None:
    """From the key that chooses a robot to its large picture in the console."""
    times: list[float] = []

    async def script(operator: Operator) -> None:
        for number in range(CHOICES):
            member = TEAM[(number + 1) % len(TEAM)]
            name = member.role
            await operator.until(lambda name=name: operator.picture_width(name) < LARGE_PX)
            began = time.monotonic()
            await operator.press(member.key)
            await operator.until(lambda name=name: operator.picture_width(name) > LARGE_PX)
            times.append(time.monotonic() - began)

    with tempfile.TemporaryDirectory() as folder:
        run_team(Path(folder), script)
    times.sort()
    note = f"the worst of {len(times)}; the median is {times[len(times) // 2] * 1e3:.0f} ms"
    report("team.chosen_picture_ms", times[-1] * 1e3, "ms", bar=300.0, note=note)


def main() -> None:
    figures = {"team.hubs_core": cost, "team.chosen_picture_ms": choice}
    for name in sys.argv[1:] or figures:
        figures[name]()


if __name__ == "__main__":
    main()
