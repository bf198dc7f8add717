"""Which topics and services of a robot are its parts: the best of several candidates; pure."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable
from typing import Any, Final

from hub.robots.ros.asking.findings import RosFindings, frame_name, plain_type
from hub.robots.ros.commands import TYPES
from hub.robots.ros.goals.goal_actions import GoalAction, actions_of
from hub.robots.ros.line import RosTopic
from hub.robots.ros.own_nodes import foreign
from hub.robots.ros_table import CommandType
from hub.values import dataclass

_ASSUMED: Final = "Twist is assumed; nodes with another type ignore it"
COMMAND_TYPES: Final = ("geometry_msgs/Twist", "geometry_msgs/TwistStamped")
IMAGE: Final = "sensor_msgs/Image"
COMPRESSED: Final = "sensor_msgs/CompressedImage"
ODOMETRY: Final = "nav_msgs/Odometry"
LASER: Final = "sensor_msgs/LaserScan"
RANGE: Final = "sensor_msgs/Range"
CAMERA_INFO: Final = "sensor_msgs/CameraInfo"
TRANSFORMS: Final = "tf2_msgs/TFMessage"
SINGLE: Final = {
    "battery": "sensor_msgs/BatteryState",
    "imu": "sensor_msgs/Imu",
    "joints": "sensor_msgs/JointState",
    "pressure": "sensor_msgs/FluidPressure",
    "diagnostics": "diagnostic_msgs/DiagnosticArray",
    "map": "nav_msgs/OccupancyGrid",
}
"""Keys of `[ros]` for which one topic is taken, and their types."""
READ: Final = frozenset(
    (*COMMAND_TYPES, IMAGE, COMPRESSED, ODOMETRY, LASER, RANGE, CAMERA_INFO, TRANSFORMS)
) | frozenset(SINGLE.values())
"""All types that are understood."""
UNSURE: Final = re.compile(r"raw|camera|unstamped|nav|teleop|joy|smoothed|mux|input|rc|safe|agg")
"""Words in names of topics that are not the robot's main one."""
_NO_PICTURE: Final = re.compile(r"depth|disparity|infra|confidence|theora|rect/|mask|debug", re.I)
_STOPS: Final = re.compile(r"(?:e_?stop|emergency_?stop|estop_trigger|e_?stop_trigger)")
_STOP_TYPES: Final = ("Trigger", "Empty", "SetBool", "EStop")


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraTopics:
    """The topics of one camera.

    Attributes:
        pictures: Of its pictures, compressed if there are such.
        compressed: Whether they are.
        info: Of its calibration; empty: there is none.
    """

    pictures: str
    compressed: bool
    info: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RosParts:
    """The parts of a robot, by the names of their topics; an empty name: it has none.

    Attributes:
        command: The topic of velocities; None: there is none.
        assumed: What is assumed of the type of that topic, in words; empty: it is known.
        commands: Other topics that take velocities.
        odometry: Of its odometry.
        odometries: Others of the same type.
        transforms: Of its frames that move.
        single: By key of `[ros]`.
        scans: Of planar scans.
        ranges: Of single range sensors.
        cameras: Its cameras, the main one first.
        stop_service: A service that stops it.
        navigation: The action of its own navigation; None: it shows none.
    """

    command: RosTopic | None
    assumed: str = ""
    commands: tuple[str, ...]
    odometry: str
    odometries: tuple[str, ...]
    transforms: str
    single: dict[str, str]
    scans: tuple[str, ...]
    ranges: tuple[str, ...]
    cameras: tuple[CameraTopics, ...]
    stop_service: str
    navigation: GoalAction | None

    @property
    def taken(self) -> frozenset[str]:
        """The names of all topics that are used."""
        cameras = (name for each in self.cameras for name in (each.pictures, each.info))
        command = self.command.name if self.command is not None else ""
        ends = self.navigation.ends if self.navigation is not None else None
        goals = (ends.goal, ends.cancel, ends.status, ends.feedback) if ends is not None else ()
        named = (command, self.odometry, self.transforms, *self.single.values(), *cameras, *goals)
        return frozenset({*named, *self.scans, *self.ranges} - {""})


def parts_of(found: RosFindings) -> RosParts:
    """The parts of a robot."""
    known, assumed = command_topics(found)
    commands = sorted((*known, *assumed), key=_command_rank(found))
    command = commands[0] if commands else None
    home = command.name.rpartition("/")[0] if command is not None else ""
    rank = _rank(home)
    odometries = sorted(
        (each.name for each in found.published(ODOMETRY)), key=_odometry_rank(found, rank)
    )
    return RosParts(
        command=command,
        assumed=_ASSUMED if command in assumed else "",
        commands=tuple(each.name for each in commands[1:]),
        odometry=odometries[0] if odometries else "",
        odometries=tuple(odometries[1:]),
        transforms=_first(found.published(TRANSFORMS), rank, _is_moving),
        single={
            key: _first(found.published(kind), rank, _is_map if key == "map" else _is_any)
            for key, kind in SINGLE.items()
        },
        scans=_all(found.published(LASER), rank),
        ranges=_all(found.published(RANGE), rank),
        cameras=_cameras(found, rank),
        stop_service=_stop_service(found, rank),
        navigation=_navigation(found, rank),
    )


def command_topics(found: RosFindings) -> tuple[list[RosTopic], list[RosTopic]]:
    """Topics that take velocities: those whose type is known, and those whose type is assumed."""
    known = [each for each in found.topics_of(*COMMAND_TYPES) if _takes(each, found)]
    # A bridge that knows the nodes knows whether one listens to velocities without a type.
    return known, _assumed(found) if not known or found.graph.whole else []


Rank = Callable[[str], Any]


def _rank(home: str) -> Rank:
    """Orders names: those near the robot's commands first, then plain ones, then short ones."""

    def rank(name: str) -> tuple[bool, int, int, int, str]:
        far = bool(home) and not name.startswith(f"{home}/")
        return far, len(UNSURE.findall(name)), name.count("/"), len(name), name

    return rank


def _command_rank(found: RosFindings) -> Callable[[RosTopic], Any]:
    rank = _rank(found.namespace)

    def of_topic(topic: RosTopic) -> tuple[object, ...]:
        alone = found.graph.whole and not foreign(topic.subscribers)
        return alone, not topic.name.endswith("cmd_vel"), *rank(topic.name)

    return of_topic


def _takes(topic: RosTopic, found: RosFindings) -> bool:
    """Whether a topic may be one of commands, not of measured velocities."""
    if found.graph.whole and foreign(topic.subscribers):
        return True
    last = topic.name.rpartition("/")[2]
    return "cmd" in topic.name or "command" in topic.name or last == "velocity"


def _assumed(found: RosFindings) -> list[RosTopic]:
    """Topics of velocities whose type a bridge for ROS 1 does not say, as if it were Twist.

    That bridge knows the types of published topics only, and velocities often have no publisher.
    Where it does not know subscribers either, it is assumed that the robot has the usual name.
    """
    graph = found.graph
    if graph.version != 1:
        return []
    names = [
        each.name
        for each in graph.topics.values()
        if not each.schema_name
        and found.counts(each.name)
        and each.name.endswith("cmd_vel")
        and foreign(each.subscribers)
    ]
    if not names and not graph.whole:
        names = [f"{found.namespace}/cmd_vel"]
    return [
        dataclasses.replace(
            graph.topics.get(name, RosTopic(name=name)),
            schema_name=TYPES[CommandType.TWIST],
            encoding="ros1",
        )
        for name in names
    ]


def _odometry_rank(found: RosFindings, rank: Rank) -> Rank:
    """Orders odometries: those that come, in a frame that does not jump, filtered ones first."""

    def of_name(name: str) -> tuple[object, ...]:
        value = found.of(name).value
        return (
            value is None,
            frame_name(value) == "map",
            not name.endswith("/filtered"),
            *rank(name),
        )

    return of_name


def _is_any(_: str) -> bool:
    return True


def _is_moving(name: str) -> bool:
    return name.endswith("/tf")


def _is_map(name: str) -> bool:
    return name.endswith("/map")


def _first(topics: Iterable[RosTopic], rank: Rank, fits: Callable[[str], bool]) -> str:
    names = [each.name for each in topics if fits(each.name)]
    return min(names, key=rank, default="")


def _all(topics: Iterable[RosTopic], rank: Rank) -> tuple[str, ...]:
    return tuple(sorted((each.name for each in topics), key=rank))


def _cameras(found: RosFindings, rank: Rank) -> tuple[CameraTopics, ...]:
    """A camera for each place with pictures in colours or grey; compressed ones are preferred."""
    infos = {each.name for each in found.published(CAMERA_INFO)}
    made: dict[str, CameraTopics] = {}
    for kind in (COMPRESSED, IMAGE):
        for name in _all(found.published(kind), rank):
            base = name.removesuffix("/compressed")
            if _NO_PICTURE.search(name) or base in made:
                continue
            near = (f"{base.rpartition('/')[0]}/camera_info", f"{base}/camera_info")
            info = next((each for each in near if each in infos), "")
            made[base] = CameraTopics(pictures=name, compressed=kind == COMPRESSED, info=info)
    return tuple(_one_for_each_place(made).values())


def _one_for_each_place(cameras: dict[str, CameraTopics]) -> dict[str, CameraTopics]:
    """The best topic of each camera: several topics beside one calibration are one camera."""
    made: dict[str, CameraTopics] = {}
    for base, each in cameras.items():
        made.setdefault(each.info or base, each)
    return made


def _navigation(found: RosFindings, rank: Rank) -> GoalAction | None:
    actions = [each for each in actions_of(found.graph) if found.counts(each.name)]
    return min(actions, key=lambda each: rank(each.name), default=None)


def _stop_service(found: RosFindings, rank: Rank) -> str:
    names = [
        each.name
        for each in found.graph.services.values()
        if found.counts(each.name)
        and _STOPS.fullmatch(each.name.rpartition("/")[2].lower())
        and plain_type(each.type).rpartition("/")[2] in _STOP_TYPES
    ]
    return min(names, key=rank, default="")
