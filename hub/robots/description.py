"""The hardware part of a robot file: the kind of robot, its limits, its hub's address."""

from __future__ import annotations

import enum
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.errors import CameraError, RobotFileError
from hub.gcm.body import MOST_CORNERS, Point32, RobotBody
from hub.ipc.endpoints import DEFAULT_PORT, LARGEST_PORT
from hub.nearest import did_you_mean
from hub.robots.left_alone import SURFACE_AFTER_S, LeftAlone
from hub.robots.video_source import video_source
from hub.toml_reader import choice, degrees, key, number, plain_name, text, truth, whole_number
from hub.values import dataclass

SHIPPED = Path(__file__).parent / "files"
ROBOTS_OWN = "robot"
"""The source of pictures for the robot's own camera."""
NOTHING_NEW_S = 240.0
NOTHING_NEW_SHARE = 0.02
"""Exploring ends if the ground in reach grew by less than this share in this time [s]."""
LONGEST_EXPLORING_S = 600.0
"""Time after which an exploring robot is back at its start [s]."""


class MissionBegin(enum.Enum):
    """The event that starts a mission, besides a mark and the operator's order.

    Attributes:
        WITH_CONTROL: An operator who takes control of the robot.
        BY_HAND: Nothing.
    """

    WITH_CONTROL = "with control"
    BY_HAND = "by hand"


_USUAL_RADIUS = 0.205
"""Radius of a robot without a body in its file: a Magellan Pro's [m]."""
_SAME_LENGTH = 1e-3
"""Lengths with a smaller difference are equal [m]."""
_LEAST_AREA = 1e-4
"""Smallest surface of a body [m^2]."""


def _corners(value: object) -> tuple[tuple[float, float], ...]:
    """The corners of a body, in counter-clockwise order."""
    corners: tuple[tuple[float, float], ...]
    corners = toml.several(toml.numbers(2, -5.0, 5.0), MOST_CORNERS)(value)
    following = (*corners[1:], corners[0])
    area = sum(x * v - u * y for (x, y), (u, v) in zip(corners, following, strict=True)) / 2.0
    if len(corners) < 3 or abs(area) < _LEAST_AREA:
        reason = f"{toml.shorten(value)} is not a list of the corners [x, y] of a surface"
        raise toml.RefusedError(reason)
    return corners if area > 0.0 else corners[::-1]


def _source(value: object) -> str:
    source: str = toml.text(1000)(value)
    try:
        video_source(source)
    except CameraError as error:
        raise toml.RefusedError(str(error)) from error
    return source


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotDescription:
    """The robot in a robot file; each field has its `key` in the file.

    Attributes:
        path: The file.
        settings: Values that replace the file's, each as "TABLE.KEY=VALUE".
        camera_fov: Field of view from left to right of another camera than the robot's own [rad].
        modules: The unchecked tables under [modules].
    """

    path: Path
    settings: tuple[str, ...]
    name: str = key(plain_name(32), meaning="the robot's name")
    kind: str = key(text(64), meaning="its kind: a shipped one, or `FILE:NAME` of your own")
    port: int = key(
        whole_number(0, LARGEST_PORT),
        DEFAULT_PORT,
        "TCP port of its hub; 0 takes a free one",
        at="hub.",
    )
    gateway: str = key(
        text(100),
        "",
        "tcp:// address where machines with keys may connect",
        at="hub.",
        without="none may",
    )
    keys: str = key(text(200), "", "folder of the keys", at="hub.", without="the user's own")
    logs: str = key(
        text(1000),
        "",
        "folder for folders of log files",
        at="hub.",
        without="where the system has such files",
    )
    linear_limit: float = key(
        number(0.01, 3.0), 0.5, "largest forward velocity [m/s]", at="limits.linear"
    )
    angular_limit: float = key(
        number(0.01, 6.0), 1.0, "largest turn rate [rad/s]", at="limits.angular"
    )
    linear_acceleration: float = key(
        number(0.05, 20.0),
        2.0,
        "fastest change of the forward velocity, braking [m/s^2]",
        at="limits.",
    )
    angular_acceleration: float = key(
        number(0.1, 50.0), 4.0, "fastest change of the turn rate, braking [rad/s^2]", at="limits."
    )
    radius: float = key(
        number(0.02, 5.0),
        math.nan,
        "circle around the robot's centre in which all of it lies [m]",
        at="body.",
        without=f"encloses the footprint, else {_USUAL_RADIUS}",
    )
    footprint: tuple[tuple[float, float], ...] = key(
        _corners,
        (),
        "corners `[x, y]` of the ground that it covers [m], x forward, y left",
        at="body.",
        without="the circle",
    )
    margin: float = key(
        number(0.0, 1.0), 0.05, "how far navigation keeps from obstacles besides [m]", at="body."
    )
    left_alone: LeftAlone = key(
        choice({each.value: each for each in LeftAlone}),
        LeftAlone.STAND,
        "what it does when it has lost its operator",
        at="safety.",
    )
    surface_after_s: float = key(
        number(0.0, 3600.0),
        SURFACE_AFTER_S,
        "how long it stays neutral before it surfaces [s]",
        at="safety.",
    )
    camera_source: str = key(
        _source,
        ROBOTS_OWN,
        "where pictures come from: `robot`, or a device, a file, a network address",
        at="camera.source",
    )
    camera_fov: float = key(
        degrees(1.0, 170.0),
        math.radians(60.0),
        "field of view from left to right of another camera [degrees]",
        at="camera.fov_deg",
        without="60",
    )
    camera_forward: float = key(
        number(-5.0, 5.0),
        0.0,
        "another camera ahead of the robot's centre [m]",
        at="camera.forward",
    )
    camera_height: float = key(
        number(0.01, 5.0), 0.3, "another camera above the ground [m]", at="camera.height"
    )
    headlight: bool = key(
        truth, default=True, meaning="whether the robot's own camera has one", at="camera."
    )
    map_resolution: float = key(
        number(0.01, 1.0), 0.05, "edge of a cell of the map [m]", at="mapping.resolution"
    )
    map_size: float = key(
        number(1.0, 1000.0), 40.0, "extent of the map in both directions [m]", at="mapping.size"
    )
    map_folder: str = key(
        text(1000), "", "where maps are saved", at="mapping.folder", without="the user's own"
    )
    mission_folder: str = key(
        text(1000), "", "where missions are kept", at="mission.folder", without="the user's own"
    )
    mission_begin: MissionBegin = key(
        choice({each.value: each for each in MissionBegin}),
        MissionBegin.WITH_CONTROL,
        "what begins a mission, besides a mark and the operator's word",
        at="mission.begin",
    )
    mission_largest_mb: float = key(
        number(1.0, 1e6),
        500.0,
        "size of a mission from which on only marks are kept [MB]",
        at="mission.largest_mb",
    )
    mission_least_free_mb: float = key(
        number(0.0, 1e6),
        50.0,
        "room on the disk below which only marks are kept [MB]",
        at="mission.least_free_mb",
    )
    nothing_new_s: float = key(
        number(5.0, 86400.0),
        NOTHING_NEW_S,
        "exploring ends when nothing new came for this time, although it drove [s]",
        at="autonomy.",
    )
    nothing_new_share: float = key(
        number(0.0, 1.0),
        NOTHING_NEW_SHARE,
        "nothing new: the ground in reach grew by less than this share",
        at="autonomy.",
    )
    longest_exploring_s: float = key(
        number(30.0, 86400.0),
        LONGEST_EXPLORING_S,
        "exploring turns back in time to be at the start after this time [s]",
        at="autonomy.longest_s",
    )
    arena: str = key(text(200), "yellow", "a shipped arena, or the path of one", at="simulation.")
    seed: int = key(
        whole_number(0, 2**63 - 1), 1, "the same seed gives the same run", at="simulation."
    )
    light: float | None = key(
        number(0.0, 1.0),
        None,
        "how bright the arena is; 0 is dark",
        at="simulation.",
        without="as the arena's file says",
    )
    modules: dict[str, Any]

    @property
    def body(self) -> RobotBody:
        """The robot's body, as the hub publishes it."""
        return RobotBody(
            name=self.name,
            kind=self.kind,
            radius=self.radius,
            footprint=tuple(Point32(x=x, y=y) for x, y in self.footprint),
        )

    @property
    def simulated(self) -> bool:
        """Whether its hardware is a simulation."""
        return bool(self.kind) and self.kind.startswith("simulated-")


def find_robot_file(name_or_path: str) -> Path:
    """The robot file at a path, or the shipped one of a name.

    Raises:
        RobotFileError: There is neither.
    """
    path = Path(name_or_path)
    if path.exists():
        return path
    names = sorted(file.stem for file in SHIPPED.glob("*.toml"))
    if name_or_path in names:
        return SHIPPED / f"{name_or_path}.toml"
    hint = did_you_mean(name_or_path, names)
    advice = f"; give the path of a robot file, or the name of a shipped one: {', '.join(names)}"
    raise RobotFileError(name_or_path, [f"there is no such file{hint or advice}"])


def read_description(
    path: Path, settings: Sequence[str] = ()
) -> tuple[RobotDescription, toml.Problems]:
    """The robot in a file, and all mistakes of the file.

    Args:
        path: The robot file.
        settings: Values that replace the file's, each as "TABLE.KEY=VALUE".

    Raises:
        RobotFileError: The file cannot be read or is not TOML.
    """
    data, problems = toml.load(path, RobotFileError)
    toml.apply_settings(data, settings, problems)
    tables = dict(toml.tables_of(RobotDescription))
    top = tables.pop("")
    fields = toml.read_table(top, data, toml.TOP, problems, tables=[*tables, "modules"])
    for name, keys in tables.items():
        fields |= toml.read_table(keys, data.get(name, {}), f"[{name}]", problems)
    fields["radius"] = _enclosing(fields["radius"], fields["footprint"], problems)
    modules = data.get("modules", {})
    if not isinstance(modules, dict):
        problems.append("modules has to be tables: [modules.NAME]")
        modules = {}
    beside = path.absolute().parent
    for name in ("keys", "logs", "map_folder", "mission_folder"):
        fields[name] = _located(fields[name], beside)
    if fields["arena"].endswith(".toml"):
        fields["arena"] = _located(fields["arena"], beside)
    if fields["camera_source"] != ROBOTS_OWN and "://" not in fields["camera_source"]:
        fields["camera_source"] = _located(fields["camera_source"], beside)
    return RobotDescription(
        path=path, settings=tuple(settings), modules=modules, **fields
    ), problems


def settings(module: str) -> str:
    """The robot file's settings for a module, in words; empty: none."""
    words = [
        f"{name} ({toml.shown(each)}): {each.meaning}"
        for name, each in toml.tables_of(RobotDescription).get(module, {}).items()
    ]
    return f"its table [{module}] has: {'; '.join(words)}" if words else ""


def _enclosing(
    radius: float, corners: tuple[tuple[float, float], ...], problems: toml.Problems
) -> float:
    """The radius of the circle that encloses the body [m]."""
    farthest = max((math.hypot(x, y) for x, y in corners), default=0.0)
    if math.isnan(radius):
        return farthest or _USUAL_RADIUS
    if radius < farthest - _SAME_LENGTH:
        text = (
            f"[body], key 'radius': {radius:g} m does not enclose the footprint, whose farthest "
            f"corner is {farthest:.3f} m off; leave the radius out"
        )
        problems.add("[body]", text, "radius")
    return radius


def _located(named: str, folder: Path) -> str:
    """A path in a robot file: relative to its folder; empty: none."""
    return str(folder / os.path.expanduser(named)) if named else ""  # noqa: PTH111 - never raises
