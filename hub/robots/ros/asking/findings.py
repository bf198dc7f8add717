"""What was found of a robot with ROS by listening to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import field
from typing import Final

from hub.errors import RosMessageError
from hub.plain_text import is_plain
from hub.robots.meshes import FetchedFiles
from hub.robots.ros.address import RosAddress
from hub.robots.ros.line import RosGraph, RosTopic
from hub.robots.ros_table import ros_name
from hub.ros.frame_tree import FrameTree, plain_frame
from hub.ros.values import RosValue
from hub.toml_reader import RefusedError
from hub.values import dataclass

_LONGEST_FRAME: Final = 64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeardTopic:
    """The messages of a topic.

    Attributes:
        messages: How many.
        rate_hz: How often [Hz]; NaN: not known.
        age: How old the newest was when it came [s]; NaN: not known.
        value: The newest message; None: none could be read.
        fault: Why not, in words.
    """

    messages: int = 0
    rate_hz: float = math.nan
    age: float = math.nan
    value: RosValue | None = None
    fault: str = ""


SILENT: Final = HeardTopic()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RosFindings:
    """A robot, as it showed itself.

    Attributes:
        address: Where it is.
        graph: Its topics and services.
        heard: The messages of topics, by their names.
        frames: Its frames.
        parameters: Its parameters by name.
        takes: Whether it takes messages of others.
        notes: Sentences of the bridge.
        files: The files that its URDF names.
        refusals: Why the bridge does not serve a topic that was tried, by its name.
        namespace: Only what is below this name counts; empty: all does.
        others: What is below these namespaces does not count: they are other robots.
    """

    address: RosAddress
    graph: RosGraph
    heard: Mapping[str, HeardTopic]
    frames: FrameTree
    parameters: Mapping[str, object]
    takes: bool = True
    notes: tuple[str, ...] = ()
    files: FetchedFiles = field(default_factory=dict)
    refusals: Mapping[str, str] = field(default_factory=dict)
    namespace: str = ""
    others: tuple[str, ...] = ()

    def of(self, topic: str) -> HeardTopic:
        """The messages of a topic."""
        return self.heard.get(topic, SILENT)

    def topics_of(self, *types: str) -> Iterator[RosTopic]:
        """The topics with one of these types, such as "nav_msgs/Odometry"."""
        for topic in self.graph.topics.values():
            if plain_type(topic.schema_name) in types and self.counts(topic.name):
                yield topic

    def published(self, *types: str) -> Iterator[RosTopic]:
        """The same, without those that no node publishes."""
        for topic in self.topics_of(*types):
            if topic.publishers or not self.graph.whole:
                yield topic

    def counts(self, name: str) -> bool:
        """Whether a name is one of ROS, within the namespace or of the whole system."""
        if not is_name(name) or name.startswith(tuple(f"{each}/" for each in self.others)):
            return False
        inside = name.startswith(f"{self.namespace}/")
        return inside or (name.count("/") == 1 and not name.endswith("cmd_vel"))


def is_name(name: str) -> bool:
    """Whether this is a whole name of ROS, such as "/base/odom"."""
    try:
        return bool(ros_name(name))
    except RefusedError:
        return False


def plain_type(name: str) -> str:
    """A type as ROS 1 writes it: "nav_msgs/Odometry"."""
    return name.replace("/msg/", "/").replace("/srv/", "/")


def frame_name(value: RosValue | None, field: str = "header.frame_id") -> str:
    """The name of a frame in a message; empty: it has none that can be used."""
    try:
        name = plain_frame(str(value.get(field))) if value is not None else ""
    except RosMessageError:
        return ""
    return name if len(name) <= _LONGEST_FRAME and is_plain(name) else ""


def number(value: object) -> float:
    """A parameter that is a number; NaN: it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return math.nan
    return float(value)
