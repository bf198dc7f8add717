"""Topics of recordings: the name and the schema of what lies under it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import field
from typing import Any

from hub.errors import MessageFormatError
from hub.ipc.definition import MessageDefinition
from hub.ipc.ros_schema import PACKAGE, ros2msg, ros_type, type_name
from hub.values import dataclass


@dataclass(frozen=True, slots=True)
class RecordedTopic:
    """A stream of messages in a recording.

    Attributes:
        name: As in the file: "/rover/GCM_RobotState".
        schema_name: The type: "rune_msgs/msg/GCMRobotState"; empty without schema.
        schema_encoding: The language of the schema: "ros2msg", "ros2idl", "jsonschema", ...
        schema: Its text.
        encoding: How payloads are coded: "cdr", "json", ...
        metadata: Further facts, such as a ROS 2 quality of service.
    """

    name: str
    schema_name: str = ""
    schema_encoding: str = "ros2msg"
    schema: bytes = b""
    encoding: str = "cdr"
    metadata: Mapping[str, str] = field(default_factory=dict)

    @property
    def robot(self) -> str:
        """The first part of a name of two parts, as Rune writes it; else empty."""
        parts = self.name.split("/")
        return parts[1] if len(parts) == 3 and not parts[0] else ""

    @property
    def message(self) -> str:
        """The last part of the name."""
        return self.name.rpartition("/")[2]

    def __hash__(self) -> int:
        """Topics of one file differ in their names."""
        return hash(self.name)


@functools.cache
def topic_of(robot: str, definition: MessageDefinition[Any]) -> RecordedTopic:
    """The topic of a robot's message, with its ROS 2 definition.

    A message that has no ROS 2 type has the name of one alone: rosbag2 refuses a file where a topic
    has none.
    """
    name = f"/{robot}/{definition.name}"
    try:
        kind, text = ros_type(definition), ros2msg(definition)
    except MessageFormatError:
        return RecordedTopic(name, f"{PACKAGE}/msg/{type_name(definition.name)}", "")
    return RecordedTopic(name, schema_name=kind, schema=text.encode())
