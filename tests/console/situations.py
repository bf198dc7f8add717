"""What an operator may meet, as states that any layout can be drawn of.

    python -m tests.console.situations FOLDER [LAYOUT]

writes a picture of each in three sizes, to be looked at.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from hub.gcm.autonomy import AUTONOMY_STATE, AutonomyState, Behaviour, DrivingMode, Phase
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, PointKind
from hub.gcm.navigation import (
    NAVIGATION_STATUS,
    Cause,
    MotionState,
    NavigationStatus,
    Point,
    Task,
)
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.ranges import RangeReadings
from hub.pose import Pose
from hub.sim.arena import load_arena
from hub.sim.spatial_pose import SpatialPose
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.picture import PictureFile
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.model.theme import DARK, Theme
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from tests.console.states import described, range_readings, robot_of
from tests.console.visualizers.known import point, points
from tests.support.footprints import distances
from tests.support.magellan import magellan_camera, magellan_sensors
from tests.support.messages import robot_state

ROOT: Final = Path(__file__).parents[2]
NOW: Final = 1000.0
SIZES: Final = ((80, 24), (120, 40), (160, 48))
CORRIDOR: Final = Pose(x=5.2, y=2.4, theta=math.pi / 2.0)
"""Where the robot is unless a situation says otherwise."""
AT_THE_WALL: Final = Pose(x=3.83, y=2.3, theta=math.pi * 0.98)

_ME, _OTHER = 7, 9
_RESOLUTION: Final = 0.05


@functools.cache
def _seen(pose: Pose) -> Picture:
    camera = magellan_camera(load_arena("yellow"), seed=0)
    camera.place(SpatialPose().at(pose))
    taken = camera.take(320, 240, 0.0)
    state = dataclasses.replace(
        camera.camera_state(0.0), robot_x=pose.x, robot_y=pose.y, robot_theta=pose.theta
    )
    return Picture(pixels=taken.pixels, camera=state)


@functools.cache
def _ranges(pose: Pose) -> RangeReadings:
    sensors = magellan_sensors(load_arena("yellow").footprints, 0)
    return range_readings(sensors.measure("sonar", pose), sensors.measure("infrared", pose))


@functools.cache
def _map() -> OccupancyMap:
    """The southern half of the arena, as a robot would have mapped it from the middle."""
    footprints = load_arena("yellow").footprints
    size = round(12.0 / _RESOLUTION)
    edges = -1.0 + _RESOLUTION * (np.arange(size) + 0.5)
    x, y = np.meshgrid(edges, edges)
    near = np.hypot(x - 4.6, y - 3.0) <= 4.2 + 0.6 * np.sin(5.0 * np.arctan2(y - 3.0, x - 4.6))
    known = near & (x >= 0.0) & (x <= 10.0) & (y >= 0.0) & (y <= 10.0)
    wall = distances(footprints, x, y) < 0.5 * _RESOLUTION
    cells = np.where(known, np.where(wall, 100, 5), -1).astype(np.int8)
    return OccupancyMap(cells=cells, resolution=_RESOLUTION, origin_x=-1.0, origin_y=-1.0)


def received(value: Any, age: float, number: int = 1) -> Received[Any]:
    return Received(value=value, measured=NOW - age, number=number)


def _mark(number: int, kind: PointKind, x: float, y: float, note: str) -> InterestPoint:
    return point(number, kind, x=x, y=y, by="ada", note=note, uncertainty=0.12, distance=2.4)


MARKS: Final = points(
    _mark(1, PointKind.VICTIM, 2.2, 1.4, "by the table"),
    _mark(2, PointKind.LANDMARK, 6.6, 3.2, "exit"),
)
HOLDS: Final = AutonomyState(
    behaviour=Behaviour.HOLD,
    pilot=DrivingMode.OPERATOR,
    x=math.nan,
    y=math.nan,
    frontier_m=math.nan,
    why="",
)
MINE: Final = ControlState(owner=_ME, operator="ada", held_s=200.0, commander_name="ada")


def robot(
    name: str,
    *,
    at: Pose = CORRIDOR,
    age: float = 0.1,
    picture_age: float | None = None,
    control: ControlState = MINE,
    autonomy: AutonomyState = HOLDS,
    task: NavigationStatus | None = None,
    phase: LinkPhase = LinkPhase.CONNECTED,
    since: float = NOW - 300.0,
    **motion: Any,
) -> RobotState:
    """A robot in the yellow arena, all that it reports `age` seconds old [s]."""
    seen = _seen(at)
    navigation = robot_state(
        **{
            "x": at.x,
            "y": at.y,
            "theta": at.theta,
            "battery_fraction": 0.74,
            "battery_voltage": 24.8,
        }
        | motion
    )
    messages = {
        CONTROL_STATE.name: received(control, age),
        ROBOT_DESCRIPTION.name: described("magellan"),
        INTEREST_POINTS.name: received(MARKS, age),
        AUTONOMY_STATE.name: received(autonomy, age),
    }
    if task is not None:
        messages[NAVIGATION_STATUS.name] = received(task, age)
    return robot_of(
        name=name,
        link=LinkState(
            phase=phase,
            since=since,
            endpoint="tcp://127.0.0.1:1381",
            number=_ME,
            owned_since="14:03",
            round_trip=0.012,
            bytes_per_s=61_000.0,
            messages_per_s=84.0,
            detail="" if phase is LinkPhase.CONNECTED else "the hub does not answer",
        ),
        picture=received(seen, age if picture_age is None else picture_age),
        camera=received(seen.camera, age),
        map=received(_map(), age + 1.0),
        navigation=received(navigation, age),
        ranges=received(_ranges(at), age),
        messages=messages,
    )


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """Something that an operator may meet.

    Attributes:
        first: What has to be seen first.
        robot: The robot of this name in it.
        state: What of the console's state is special.
    """

    first: str
    robot: Callable[[str], RobotState]
    state: dict[str, Any] = dataclasses.field(default_factory=dict)


_DRIVES: Final[dict[str, Any]] = {
    "linear": 0.42,
    "angular": 0.1,
    "commanded_linear": 0.5,
    "commanded_angular": 0.1,
    "motion": MotionState.MOVING,
}
_ROUTE: Final = tuple(
    Point(x=x, y=y) for x, y in ((5.2, 2.4), (5.1, 3.2), (4.7, 4.2), (4.2, 4.6), (3.2, 4.6))
)


def _told(text: str, seconds: float, *, alarm: bool = False) -> Notice:
    return Notice(text=text, when=NOW - seconds, clock="14:06:40", robot="robot", alarm=alarm)


_HISTORY: Final = (
    _told("you have control", 200.0),
    _told("victim 1 is marked", 120.0),
    _told("landmark 2 is marked", 90.0),
)

SITUATIONS: Final[dict[str, Situation]] = {
    "driving": Situation(
        first="the video and where the robot goes",
        robot=lambda name: robot(name, **_DRIVES),
        state={"held": ("w",)},
    ),
    "near-wall": Situation(
        first="something is about to touch, and on which side",
        robot=lambda name: robot(name, at=AT_THE_WALL, **(_DRIVES | {"linear": 0.1})),
        state={"held": ("w",)},
    ),
    "stale-picture": Situation(
        first="the picture is old",
        robot=lambda name: robot(name, picture_age=4.2, **_DRIVES),
        state={"held": ("w",)},
    ),
    "lost-link": Situation(
        first="the link is lost, and since when; nothing else is known",
        robot=lambda name: robot(
            name, age=30.0, phase=LinkPhase.LOST, since=NOW - 30.0, motion=MotionState.STANDING
        ),
    ),
    "asked-for-control": Situation(
        first="who asks, and which keys answer",
        robot=lambda name: robot(
            name,
            control=dataclasses.replace(
                MINE, asker=_OTHER, asker_name="console", asker_operator="bob", left_s=8.0
            ),
            **_DRIVES,
        ),
    ),
    "exploring": Situation(
        first="the robot drives by itself, and where to",
        robot=lambda name: robot(
            name,
            autonomy=AutonomyState(
                behaviour=Behaviour.EXPLORE,
                pilot=DrivingMode.AUTONOMY,
                x=3.2,
                y=4.6,
                frontier_m=6.4,
                why="explores: a frontier of 2.1 m, 3.1 m away",
                phase=Phase.ACTIVE,
                asked=Behaviour.EXPLORE,
                explored=0.62,
                distance_m=3.1,
                seconds=131.0,
                sender=3,
                number=1,
            ),
            task=NavigationStatus(
                number=4,
                task=Task.GOING,
                sender=3,
                driver=3,
                points_left=1,
                distance_left=3.1,
                why="",
                path=_ROUTE,
                x=_ROUTE[-1].x,
                y=_ROUTE[-1].y,
                seconds=9.0,
            ),
            **(_DRIVES | {"motion": MotionState.GOING}),
        ),
    ),
    "goal-blocked": Situation(
        first="the robot gave its goal up, and why",
        robot=lambda name: robot(
            name,
            autonomy=AutonomyState(
                behaviour=Behaviour.HOLD,
                pilot=DrivingMode.NOBODY,
                x=math.nan,
                y=math.nan,
                frontier_m=math.nan,
                why="the goal is blocked",
            ),
            task=NavigationStatus(
                number=5,
                task=Task.BLOCKED,
                sender=_ME,
                driver=0,
                points_left=1,
                distance_left=2.0,
                why="no way around the table",
                path=(),
                cause=Cause.CLOSED,
                x=_ROUTE[-1].x,
                y=_ROUTE[-1].y,
                seconds=41.0,
                ended_s=2.0,
            ),
        ),
        state={
            "notices": (
                *_HISTORY,
                _told("going BLOCKED: no way around the table (41 s)", 2.0, alarm=True),
            )
        },
    ),
    "mark-refused": Situation(
        first="the mark was not taken, and why",
        robot=robot,
        state={
            "notices": (
                *_HISTORY,
                _told("victim refused: the place is above the horizon", 1.0, alarm=True),
            )
        },
    ),
    "low-battery": Situation(
        first="the battery is nearly empty",
        robot=lambda name: robot(name, battery_fraction=0.08, battery_voltage=21.9, **_DRIVES),
        state={"held": ("w",)},
    ),
}


@functools.cache
def shipped(name: str) -> LayoutSpec:
    """A layout of Rune, opened once."""
    return open_layout(ROOT / "layouts" / f"{name}.xml")


def scene(
    layout: LayoutSpec, situation: Situation, size: tuple[int, int], theme: Theme = DARK
) -> Cells:
    """What a console of this size [cells] shows."""
    view = View(layout, spent=lambda: 0.0)
    view.resize(*size)
    state = dataclasses.replace(
        ConsoleState.at_start(layout, NOW, "ada"),
        **{"began": 0.0, "theme": theme, "notices": _HISTORY, "releases_reported": True}
        | situation.state,
        robots={each.name: situation.robot(each.name) for each in layout.robots},
    )
    cells = view.render(state)
    assert cells is not None
    return cells


def main() -> None:
    folder, name = Path(sys.argv[1]), (*sys.argv[2:], "search")[0]
    folder.mkdir(exist_ok=True)
    layout = shipped(name)
    for title, situation in SITUATIONS.items():
        for size in SIZES:
            cells = scene(layout, situation, size)
            file = PictureFile(folder / f"{name}-{title}-{size[0]}x{size[1]}.png")
            file.write(file.draw(cells, ()))


if __name__ == "__main__":
    main()
