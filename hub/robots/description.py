"""The hardware part of a robot file: which kind of robot, its limits, where its hub listens."""

from __future__ import annotations

import enum
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.errors import CameraError, RobotFileError
from hub.gcm.body import MOST_CORNERS, Point32, RobotBody
from hub.ipc.endpoints import DEFAULT_PORT
from hub.robots.left_alone import SURFACE_AFTER_S, LeftAlone
from hub.robots.video_source import video_source

SHIPPED = Path(__file__).parent / "files"
ROBOTS_OWN = "robot"
"""The source of pictures that is the robot's own camera."""
NOTHING_NEW_S = 240.0
NOTHING_NEW_SHARE = 0.02
"""Exploring ends when the ground in reach grew by less than this share for this time [s]."""
LONGEST_EXPLORING_S = 600.0
"""Exploring ends in time for the robot to be back at its start then [s]."""


class MissionBegin(enum.Enum):
    """What begins a mission, besides a mark and the operator's word.

    Attributes:
        WITH_CONTROL: An operator who takes control of the robot.
        BY_HAND: Nothing.
    """

    WITH_CONTROL = "with control"
    BY_HAND = "by hand"


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotDescription:
    """What a robot file says of the robot itself.

    Attributes:
        path: The file.
        settings: Values that stand in place of the file's, each as "TABLE.KEY=VALUE".
        name: The robot's name.
        kind: Its kind; `hub.robots.registry` knows which there are.
        port: TCP port of its central; 0 takes a free one.
        gateway: tcp:// address where machines with keys may connect; empty: none may.
        keys: Folder of the keys; empty: the user's own.
        logs: Folder for folders of log files; empty: where the system has such files.
        linear_limit: Largest forward velocity [m/s].
        angular_limit: Largest turn rate [rad/s].
        arena: Arena of a simulated robot: a shipped name, or a path.
        seed: Seed of the simulation.
        light: How bright the arena is, 0 (dark) to 1; None: as its file says.
        linear_acceleration: Fastest change of the forward velocity, braking [m/s^2].
        angular_acceleration: Fastest change of the turn rate, braking [rad/s^2].
        radius: Of the circle around the robot's centre in which all of it lies [m].
        footprint: Corners of the ground that it covers [m, m], counter-clockwise; none: the circle.
        margin: How far it keeps from obstacles besides [m].
        camera_source: Where pictures come from: "robot" for the robot's own camera, or a device,
            file or network address.
        camera_fov: Field of view from left to right of such another camera [rad].
        camera_forward: Such another camera ahead of the robot's centre [m].
        camera_height: Such another camera above the ground [m].
        headlight: Whether it has one.
        map_resolution: Edge of a cell of the map [m].
        map_size: Extent of the map in both directions, the start in its middle [m].
        map_folder: Where maps are saved; empty: the user's own folder of data.
        mission_folder: Where missions are kept; empty: the user's own folder of states.
        mission_begin: What begins a mission, besides a mark and the operator's word.
        mission_largest_mb: Size of a mission from which on only marks are kept [MB].
        mission_least_free_mb: Room on the disk below which only marks are kept [MB].
        nothing_new_s: Exploring ends when nothing new came for this time, although it drove [s].
        nothing_new_share: Nothing new means that the ground in reach grew by less than this.
        longest_exploring_s: The robot is back from exploring after this time, as far as it can [s].
        left_alone: What it does when it has lost its operator.
        surface_after_s: If it surfaces then, for how long it keeps neutral before [s].
        modules: The tables under [modules], not yet checked.
    """

    path: Path
    settings: tuple[str, ...]
    name: str
    kind: str
    port: int
    gateway: str
    keys: str
    logs: str
    linear_limit: float
    angular_limit: float
    arena: str
    seed: int
    light: float | None
    linear_acceleration: float
    angular_acceleration: float
    radius: float
    footprint: tuple[tuple[float, float], ...]
    margin: float
    camera_source: str
    camera_fov: float
    camera_forward: float
    camera_height: float
    headlight: bool
    map_resolution: float
    map_size: float
    map_folder: str
    mission_folder: str
    mission_begin: MissionBegin
    mission_largest_mb: float
    mission_least_free_mb: float
    nothing_new_s: float
    nothing_new_share: float
    longest_exploring_s: float
    left_alone: LeftAlone
    surface_after_s: float
    modules: dict[str, Any]

    @property
    def body(self) -> RobotBody:
        """What the hub tells about the robot."""
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


_RADIUS = toml.number(0.02, 5.0)
_USUAL_RADIUS = 0.205
"""Of a robot whose file says nothing of its body: a Magellan Pro's [m]."""
_SAME_LENGTH = 1e-3
"""Lengths that differ by less are the same [m]."""
_LEAST_AREA = 1e-4
"""A surface that is smaller is none [m^2]."""


def _corners(value: object) -> tuple[tuple[float, float], ...]:
    """The corners of a body, put in counter-clockwise order."""
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


_TOP = {
    "name": toml.Key(toml.plain_name(32)),
    "kind": toml.Key(toml.text(64)),
}
_TABLES = {
    "hub": {
        "port": toml.Key(toml.whole_number(0, 65529), DEFAULT_PORT),
        "gateway": toml.Key(toml.text(100), ""),
        "keys": toml.Key(toml.text(200), ""),
        "logs": toml.Key(toml.text(1000), ""),
    },
    "limits": {
        "linear": toml.Key(toml.number(0.01, 3.0), 0.5, "linear_limit"),
        "angular": toml.Key(toml.number(0.01, 6.0), 1.0, "angular_limit"),
        "linear_acceleration": toml.Key(toml.number(0.05, 20.0), 2.0),
        "angular_acceleration": toml.Key(toml.number(0.1, 50.0), 4.0),
    },
    "body": {
        "radius": toml.Key(_RADIUS, None),
        "footprint": toml.Key(_corners, ()),
        "margin": toml.Key(toml.number(0.0, 1.0), 0.05),
    },
    "safety": {
        "left_alone": toml.Key(
            toml.choice({each.value: each for each in LeftAlone}), LeftAlone.STAND
        ),
        "surface_after_s": toml.Key(toml.number(0.0, 3600.0), SURFACE_AFTER_S),
    },
    "camera": {
        "source": toml.Key(_source, ROBOTS_OWN, "camera_source"),
        "fov_deg": toml.Key(toml.number(1.0, 170.0), 60.0, "camera_fov"),
        "forward": toml.Key(toml.number(-5.0, 5.0), 0.0, "camera_forward"),
        "height": toml.Key(toml.number(0.01, 5.0), 0.3, "camera_height"),
        "headlight": toml.Key(toml.truth, default=True),
    },
    "mapping": {
        "resolution": toml.Key(
            toml.number(0.01, 1.0), 0.05, "map_resolution", "edge of a cell of the map [m]"
        ),
        "size": toml.Key(
            toml.number(1.0, 1000.0), 40.0, "map_size", "extent of the map in both directions [m]"
        ),
        "folder": toml.Key(
            toml.text(1000), "", "map_folder", "where maps are saved; without: the user's own"
        ),
    },
    "mission": {
        "folder": toml.Key(
            toml.text(1000),
            "",
            "mission_folder",
            "where missions are kept; without: the user's own",
        ),
        "begin": toml.Key(
            toml.choice({each.value: each for each in MissionBegin}),
            MissionBegin.WITH_CONTROL,
            "mission_begin",
            "what begins a mission, besides a mark and the operator's word",
        ),
        "largest_mb": toml.Key(
            toml.number(1.0, 1e6),
            500.0,
            "mission_largest_mb",
            "size of a mission from which on only marks are kept [MB]",
        ),
        "least_free_mb": toml.Key(
            toml.number(0.0, 1e6),
            50.0,
            "mission_least_free_mb",
            "room on the disk below which only marks are kept [MB]",
        ),
    },
    "autonomy": {
        "nothing_new_s": toml.Key(
            toml.number(5.0, 86400.0),
            NOTHING_NEW_S,
            meaning="exploring ends when nothing new came for this time, although it drove [s]",
        ),
        "nothing_new_share": toml.Key(
            toml.number(0.0, 1.0),
            NOTHING_NEW_SHARE,
            meaning="nothing new: the ground in reach grew by less than this share",
        ),
        "longest_s": toml.Key(
            toml.number(30.0, 86400.0),
            LONGEST_EXPLORING_S,
            "longest_exploring_s",
            meaning="exploring turns back in time to be at the start after this time [s]",
        ),
    },
    "simulation": {
        "arena": toml.Key(toml.text(200), "yellow"),
        "seed": toml.Key(toml.whole_number(0, 2**63 - 1), 1),
        "light": toml.Key(toml.number(0.0, 1.0), None),
    },
}


def find_robot_file(name_or_path: str) -> Path:
    """The robot file of that path, or the shipped one of that name.

    Raises:
        RobotFileError: There is neither.
    """
    path = Path(name_or_path)
    if path.exists():
        return path
    names = sorted(file.stem for file in SHIPPED.glob("*.toml"))
    if name_or_path in names:
        return SHIPPED / f"{name_or_path}.toml"
    hint = toml.nearest(name_or_path, names)
    advice = f"; give the path of a robot file, or the name of a shipped one: {', '.join(names)}"
    raise RobotFileError(name_or_path, [f"there is no such file{hint or advice}"])


def read_description(
    path: Path, settings: Sequence[str] = ()
) -> tuple[RobotDescription, toml.Problems]:
    """What the file says of the robot, and all that is wrong with it.

    Args:
        path: The robot file.
        settings: Values in place of the file's, each as "TABLE.KEY=VALUE".

    Raises:
        RobotFileError: The file cannot be read or is not TOML.
    """
    data, problems = toml.load(path, RobotFileError)
    toml.apply_settings(data, settings, problems)
    fields = toml.read_table(_TOP, data, toml.TOP, problems, tables=[*_TABLES, "modules"])
    for name, keys in _TABLES.items():
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
    fields["camera_fov"] = math.radians(fields["camera_fov"])
    return RobotDescription(
        path=path, settings=tuple(settings), modules=modules, **fields
    ), problems


def settings(module: str) -> str:
    """What the robot file can set for a module, in words; empty: nothing."""
    keys = _TABLES.get(module, {})
    told = [
        f"{name} ({key.default}): {key.meaning}" if key.default != "" else f"{name}: {key.meaning}"
        for name, key in keys.items()
    ]
    return f"its table [{module}] has: {'; '.join(told)}" if told else ""


def _enclosing(
    radius: float | None, corners: tuple[tuple[float, float], ...] | None, problems: toml.Problems
) -> float:
    """The radius of the circle in which all of the body lies [m]."""
    farthest = max((math.hypot(x, y) for x, y in corners or ()), default=0.0)
    if radius is None:
        return farthest or _USUAL_RADIUS
    if radius < farthest - _SAME_LENGTH:
        text = (
            f"[body], key 'radius': {radius:g} m does not enclose the footprint, whose farthest "
            f"corner is {farthest:.3f} m off; leave the radius out"
        )
        problems.add("[body]", text, "radius")
    return radius


def _located(named: str, folder: Path) -> str:
    """A path that a robot file names: relative ones begin beside it; empty where it names none."""
    return str(folder / os.path.expanduser(named)) if named else ""  # noqa: PTH111 - never raises
