"""Cost of the simulator: pictures and sonar scans at many poses of the yellow arena."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np

from benchmarks.figures import median_ms, report
from hub.sim.afloat.blimp import SimulatedBlimp
from hub.sim.afloat.rov import SimulatedRov
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.vehicle import STEP
from hub.sim.arena import load_arena
from hub.sim.arena_specs import WaterSpec
from hub.sim.camera.lighting import Lighting
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.camera.view import View
from hub.sim.ground.chassis import TRACKED
from hub.sim.rough_base import STEP as GROUND_STEP
from hub.sim.rough_base import RoughBase
from hub.sim.spatial_pose import SpatialPose
from tests.hub.sim.arenas import free_poses
from tests.hub.sim.camera.rough_ground import on, rough_ground
from tests.support.magellan import magellan_camera, magellan_sensors

POSES = 200


def main() -> None:
    arena = load_arena("yellow")
    poses = free_poses(arena, POSES, 2003, 0.0, 10.0)
    camera = magellan_camera(arena)
    note = f"median over {POSES} poses, {len(arena.boxes)} boxes, one core"
    for width, height, bar in ((160, 120, 6.0), (320, 240, 20.0)):

        def draw(number: int, width: int = width, height: int = height) -> None:
            pose = poses[number % POSES]
            camera.place(SpatialPose().at(pose))
            camera.capture(width, height)

        value = median_ms(draw, POSES)
        report(f"sim.picture_{width}x{height}_ms", value, "ms", bar=bar, note=note)

    tilted_picture()
    terrain_picture()
    water_pictures()
    float_step()

    sensors = magellan_sensors(arena.footprints, 1)
    value = median_ms(lambda number: sensors.measure("sonar", poses[number % POSES]), 5 * POSES)
    report("sim.sonar_scan_ms", value, "ms", bar=0.3, note=note + ", 16 sonars")
    contact_steps()


def contact_steps() -> None:
    """A tracked base drives through the rubble of the red arena; each step is 10 ms long."""
    arena = load_arena("red")
    start = replace(arena.start, x=0.8, y=2.2, theta=1.6)
    chassis = replace(TRACKED, grip=2.0)
    base = RoughBase(replace(arena, start=start), chassis, flippers=(0.6, 0.0))
    times = []
    for number in range(2000):
        if base.stuck or number % 400 == 0:
            base.command(-0.3 if base.commanded[0] > 0.0 else 0.3, 0.2)
        begin = time.thread_time()
        base.advance(GROUND_STEP)
        times.append(time.thread_time() - begin)
    value = sorted(times)[len(times) // 2] * 1e6
    note = f"median over {len(times)} steps, thread time, {len(base.loads)} contact points"
    report("sim.contact_step_us", value, "us", bar=300.0, note=note)


def float_step() -> None:
    """Blimp and underwater robot with sensors, holds and thrusters."""
    arena = load_arena("yellow")
    start = SpatialPose(x=arena.start.x, y=arena.start.y, z=1.5)
    blimp = SimulatedBlimp(Surroundings.in_air(arena), start=start)
    water = WaterSpec(surface=3.0)
    rov = SimulatedRov(Surroundings.under_water(arena), start=start, water=water)
    blimp.command(surge=0.1, yaw=0.2)
    rov.command(surge=0.1, yaw=0.2)
    clock = time.thread_time
    values = (
        median_ms(lambda _: blimp.advance(100 * STEP), 20, clock=clock),
        median_ms(lambda _: rov.advance(100 * STEP), 20, clock=clock),
    )
    note = "thread time, the slower of blimp and ROV, median of 20 times 100 steps"
    report("sim.float_step_us", max(values) * 10.0, "us", bar=60.0, note=note)


def tilted_picture() -> None:
    """A rover that pitches and rolls, and a blimp that looks steeply down, by turns."""
    arena = load_arena("yellow")
    caster = RayCaster(arena)
    random = np.random.default_rng(1)
    views = []
    for number, pose in enumerate(free_poses(arena, POSES, 2003, 0.0, 10.0)):
        z, pitch = ((0.37, -0.17), (2.2, -0.78), (2.2, -1.48))[number % 3]
        roll = float(random.uniform(-0.3, 0.3))
        fov = math.radians(60.0)
        view = View(
            x=pose.x, y=pose.y, z=z, yaw=pose.theta, pitch=pitch, roll=roll, horizontal_fov=fov
        )
        views.append(view)
    value = median_ms(
        lambda number: caster.picture(views[number % POSES], 160, 120),
        POSES,
        clock=time.thread_time,
    )
    note = f"thread time, median over {POSES} views at 160x120, rolled"
    report("sim.picture_tilted_ms", value, "ms", bar=4.0, note=note)


def terrain_picture() -> None:
    """A rover that tilts on rough ground between walls, and a blimp above it, by turns."""
    ground = rough_ground()
    caster = RayCaster(on(ground, load_arena("yellow")))
    random = np.random.default_rng(2)
    views = []
    for number in range(POSES):
        x, y = random.uniform(1.0, 9.0, 2).tolist()
        above, pitch = ((0.37, -0.1), (2.2, -0.78), (2.2, -1.4))[number % 3]
        view = View(
            x=x,
            y=y,
            z=float(ground.heights[int(y / ground.cell), int(x / ground.cell)]) + above,
            yaw=float(random.uniform(-3.0, 3.0)),
            pitch=pitch + float(random.uniform(-0.15, 0.15)),
            roll=float(random.uniform(-0.2, 0.2)),
            horizontal_fov=math.radians(60.0),
        )
        views.append(view)
    value = median_ms(
        lambda number: caster.picture(views[number % POSES], 160, 120),
        POSES,
        clock=time.thread_time,
    )
    note = f"thread time, median over {POSES} views at 160x120, rolled, {ground.heights.size} cells"
    report("sim.picture_terrain_ms", value, "ms", bar=6.0, note=note)


def water_pictures() -> None:
    """What water adds to pictures of the pool, from inside with a lamp, and from above."""
    arena = load_arena("pool")
    casters = RayCaster(arena), RayCaster(replace(arena, water=None))
    random = np.random.default_rng(4)
    inside, above = [], []
    for _ in range(POSES):
        view = View(
            x=float(random.uniform(0.6, 5.4)),
            y=float(random.uniform(0.6, 7.4)),
            z=float(random.uniform(0.4, 2.0)),
            yaw=float(random.uniform(-3.0, 3.0)),
            pitch=-0.2,
            roll=0.05,
            horizontal_fov=math.radians(64.0),
        )
        inside.append(_added_ms(casters, view, Lighting(headlight=0.8)))
        above.append(_added_ms(casters, replace(view, z=3.0 + view.z, pitch=-1.0), Lighting()))
    note = f"thread time, median over {POSES} views at 160x120, less the dry picture"
    report("sim.water_ms", float(np.median(inside)), "ms", bar=0.6, note=note + ", with lamp")
    report("sim.water_above_ms", float(np.median(above)), "ms", bar=0.6, note=note)


def _added_ms(casters: tuple[RayCaster, RayCaster], view: View, lighting: Lighting) -> float:
    """Time of a picture with water in a light, less that of a dry one by day [ms]."""
    wet_ms, dry_ms = (
        median_ms(
            lambda _, caster=caster, light=light: caster.picture(view, 160, 120, light),
            5,
            warmup=1,
            clock=time.thread_time,
        )
        for caster, light in zip(casters, (lighting, Lighting()), strict=True)
    )
    return wet_ms - dry_ms


if __name__ == "__main__":
    main()
