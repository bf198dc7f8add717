"""What the shipped layouts look like, as text files that can be read and compared.

After a wanted change, write them anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/console
"""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import numpy as np

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.mapping import INTEREST_POINTS, PointKind
from hub.gcm.navigation import MotionState
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.ranges import RANGES
from hub.gcm.supervision import MODULE_REPORTS
from rune_tui.compositor.picture import plain_text
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.view import View
from tests.console.situations import shipped
from tests.console.states import described, range_readings, renamed, rendered, robot_of
from tests.console.visualizers.known import module, modules, point, points
from tests.support.cases import for_each
from tests.support.messages import camera_state, robot_state

ROOT = Path(__file__).parents[2]
SNAPSHOTS = ROOT / "tests" / "golden" / "layouts"
NOW = 100.0

CAMERA = camera_state(
    pan=0.5,
    tilt=-0.1,
    zoom=0.2,
    horizontal_fov=0.7,
    vertical_fov=0.53,
    mount_forward=0.05,
    mount_height=0.37,
    pan_limit=1.745,
    tilt_limit=0.436,
)
NAVIGATION = robot_state(
    x=1.0,
    y=2.0,
    theta=0.3,
    linear=0.42,
    angular=-0.2,
    commanded_linear=0.5,
    commanded_angular=-0.2,
    battery_voltage=24.6,
    motion=MotionState.MOVING,
)


READINGS = range_readings(sonar=np.linspace(0.5, 4.0, 16, dtype=np.float32))
FOUND = points(
    point(1, x=2.5, y=2.2, stamp=1e9, by="ada", note="under the table"),
    point(2, PointKind.LANDMARK, x=0.2, y=1.0, stamp=1e9, by="ada", note="sign"),
)
MODULES = modules(
    module(
        "vision",
        pid=17,
        capabilities="VIS_VID",
        always=1,
        starts=2,
        processor=0.07,
        memory_mb=61.0,
        age_s=12.0,
        why="runs again; it was ended by signal 9",
    )
)


def room() -> OccupancyMap:
    """A room of four by three metres that is not known everywhere."""
    cells = np.full((80, 100), -1, np.int8)
    cells[10:70, 10:90] = 0
    cells[[10, 69], 10:90] = 100
    cells[10:70, [10, 89]] = 100
    return OccupancyMap(cells=cells, resolution=0.05, origin_x=-1.0, origin_y=0.0)


def robot(age: float) -> RobotState:
    """A robot that drives; its data is `age` seconds old."""
    rows, columns = np.mgrid[0:120, 0:160]
    shades = [columns, rows * 2, (rows // 10 + columns // 10) % 2 * 200]
    pixels = np.stack(shades, -1).astype(np.uint8)
    measured = NOW - age
    return robot_of(
        name="robot",
        link=LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="tcp://127.0.0.1:1381"),
        picture=Received(value=Picture(pixels=pixels, camera=CAMERA), measured=measured, number=1),
        navigation=Received(value=NAVIGATION, measured=measured, number=2),
        camera=Received(value=CAMERA, measured=measured, number=3),
        map=Received(value=room(), measured=measured, number=4),
        messages={
            ROBOT_DESCRIPTION.name: described("magellan"),
            INTEREST_POINTS.name: Received(value=FOUND, measured=measured, number=5),
            RANGES.name: Received(value=READINGS, measured=measured, number=7),
            MODULE_REPORTS.name: Received(value=MODULES, measured=measured, number=6),
        },
    )


LOST = RobotState(
    name="robot",
    link=LinkState(phase=LinkPhase.LOST, since=NOW - 7.0, endpoint="tcp://127.0.0.1:1381"),
)


@for_each("size", [(120, 40), (80, 24), (20, 5)])
@for_each("layout", sorted(path.stem for path in (ROOT / "layouts").glob("*.xml")))
@for_each("state", ["live", "stale", "lost"])
def test_layout_looks_as_it_did(layout: str, size: tuple[int, int], state: str) -> None:
    opened = shipped(layout)
    view = View(opened, spent=lambda: 0.0)
    view.resize(*size)
    shown = {"live": robot(0.05), "stale": robot(4.2), "lost": LOST}[state]
    several = len(opened.robots) > 1 and shown is not LOST
    robots = {
        each.name: renamed(shown, each.name) if several else shown.with_(name=each.name)
        for each in opened.robots
    }
    console = dataclasses.replace(ConsoleState.at_start(opened, NOW), held=("w",))
    cells = rendered(view, robots, console)
    assert cells is not None
    assert (cells.columns, cells.rows) == size
    text = plain_text(cells)
    path = SNAPSHOTS / f"{layout}-{size[0]}x{size[1]}-{state}.txt"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    assert text == path.read_text()
