"""Cost of the simulator: pictures and sonar scans at many poses of the yellow arena."""

from __future__ import annotations

from benchmarks.figures import median_ms, report
from hub.robots.magellan import SimulatedCamera
from hub.sim.arena import load_arena
from tests.hub.sim.arenas import free_poses
from tests.support.magellan import magellan_sensors

POSES = 200


def main() -> None:
    arena = load_arena("yellow")
    poses = free_poses(arena, POSES, 2003, 0.0, 10.0)
    camera = SimulatedCamera(arena)
    note = f"median over {POSES} poses, {len(arena.boxes)} boxes, one core"
    for width, height, bar in ((160, 120, 6.0), (320, 240, 20.0)):

        def draw(number: int, width: int = width, height: int = height) -> None:
            pose = poses[number % POSES]
            camera.place(pose.x, pose.y, pose.theta)
            camera.capture(width, height)

        value = median_ms(draw, POSES)
        report(f"sim.picture_{width}x{height}_ms", value, "ms", bar=bar, note=note)

    sensors = magellan_sensors(arena.footprints, 1)
    value = median_ms(lambda number: sensors.measure("sonar", poses[number % POSES]), 5 * POSES)
    report("sim.sonar_scan_ms", value, "ms", bar=0.3, note=note + ", 16 sonars")


if __name__ == "__main__":
    main()
