"""What drawing the world costs: the camera's picture, the ground over it, the map, ranges.

Each is drawn as by the console while the robot drives: on a clear canvas of 160 x 96 pixels, the
picture 160 x 120 pixels, the map 400 x 400 cells.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchmarks.figures import median_ms, report, say
from hub.gcm.navigation import MotionState
from hub.gcm.navigation import RobotState as NavigationState
from hub.gcm.occupancy_map import OccupancyMap
from hub.sim.arena import load_arena
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.registry import VISUALIZERS
from tests.console.states import range_readings, robot_of, visualizer_spec
from tests.support.magellan import magellan_camera

WIDTH, HEIGHT = 160, 96
RUNS = 200
STATES = 20
NOW = 100.0

DRAWN: tuple[tuple[str, str, float, dict[str, Any]], ...] = (
    ("camera_fit", "visualizeCameraImage", 1.0, {"crosshair": "on"}),
    ("camera_fill", "visualizeCameraImage", 1.0, {"fit": "fill"}),
    ("ground_grid", "visualizeGroundPlane", 2.0, {}),
    ("ground_rings", "visualizeGroundPlane", 2.0, {"lines": "rings"}),
    ("map_north_up", "visualizeMapData", 4.0, {}),
    ("map_robot_up", "visualizeMapData", 4.0, {"up": "robot"}),
    ("map_whole", "visualizeMapData", 4.0, {"show": "whole"}),
    ("ranges", "visualizeRangeData", 4.0, {}),
)
"""Name of the figure, visualizer, most it may take [ms], and its options."""


def driving(step: int) -> RobotState:
    """A robot on an arc, its camera in the yellow arena, its map of noise with walls."""
    heading = 0.05 * step
    navigation = NavigationState(
        stamp=0.0,
        x=math.sin(heading),
        y=1.0 - math.cos(heading),
        theta=heading,
        linear=0.5,
        angular=0.5,
        commanded_linear=0.5,
        commanded_angular=0.5,
        bumpers=0,
        battery_voltage=24.0,
        battery_fraction=0.9,
        motion=MotionState.MOVING,
        refused=0,
    )
    link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="tcp://127.0.0.1:1381")
    return robot_of(
        name="magellan",
        link=link,
        picture=received(PICTURE, step),
        camera=received(PICTURE.camera, step),
        map=received(MAP, step),
        navigation=received(navigation, step),
        ranges=received(READINGS, step),
    )


def received(value: Any, number: int) -> Received[Any]:
    return Received(value=value, measured=NOW - 0.1, number=number)


def picture() -> Picture:
    camera = magellan_camera(load_arena("yellow"), seed=0)
    return Picture(pixels=camera.take(160, 120, 0.0).pixels, camera=camera.camera_state(0.0))


def grid() -> OccupancyMap:
    cells = np.random.default_rng(0).integers(-1, 40, (400, 400)).astype(np.int8)
    cells[::50] = cells[:, ::50] = 100
    return OccupancyMap(cells=cells, resolution=0.05, origin_x=-10.0, origin_y=-10.0)


PICTURE, MAP = picture(), grid()
READINGS = range_readings(np.linspace(0.4, 3.0, 16, dtype=np.float32), 1.0)


def main() -> None:
    say(f"{WIDTH} x {HEIGHT} pixels, {RUNS} drawings")
    robots = [driving(step) for step in range(STATES)]
    state = ConsoleState(now=NOW)
    for name, function, bar, options in DRAWN:
        shown = VISUALIZERS[function].from_spec(visualizer_spec(function, **options))
        for robot in robots:
            shown.source(robot, state)
        time = median_ms(
            lambda step, shown=shown: shown.draw(
                Canvas.blank(WIDTH, HEIGHT), robots[step % STATES], state
            ),
            RUNS,
        )
        report(f"console.draw_{name}_ms", time, "ms", bar=bar)


if __name__ == "__main__":
    main()
