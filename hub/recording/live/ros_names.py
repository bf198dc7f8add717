"""Topics of recordings with the names that ROS 2 has for them, for its tools.

Each message keeps a topic of its own, under its usual name if it is a type of ROS 2. What it holds
of ROS 2 has topics beside it; see `hub.ros.standard_topics`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

from hub.errors import CodecError
from hub.gcm.vision import IMAGE
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.codegen import Buffer
from hub.recording.ros_quality import QOS, TYPE_HASH
from hub.recording.topics import RecordedTopic, topic_of
from hub.ros import standard_topics
from hub.ros.standard_topics import CAMERA, MARKS, ODOMETRY, PICTURE, SCAN, TRANSLATED, USUAL_NAMES
from hub.ros.type_hashes import type_hash

_LONGEST = "\n".join(f"    {part}: {number}" for part, number in (
    ("sec", 9223372036), ("nsec", 854775807)
))  # fmt: skip


class RosTopics:
    """The topics of one robot."""

    def __init__(self, robot: str) -> None:
        """Translate nothing yet."""
        self._robot = robot
        self._topics: dict[tuple[str, str], RecordedTopic] = {}

    def named(self, definition: MessageDefinition[Any], topic: RecordedTopic) -> RecordedTopic:
        """The topic of a message, under the name that ROS 2 has for it."""
        key = definition.name, ""
        if key not in self._topics:
            name = USUAL_NAMES.get(definition.name, topic.name)
            self._topics[key] = _for_ros(name, topic, definition)
        return self._topics[key]

    def translated(
        self, definition: MessageDefinition[Any], payload: Buffer
    ) -> Iterator[tuple[RecordedTopic, bytes]]:
        """The messages of ROS 2 that a message holds; none if it cannot be read."""
        if definition not in TRANSLATED:
            return
        try:
            parts = [*standard_topics.translated(definition, definition.decode(payload))]
        except CodecError:
            return
        for name, part, content in parts:
            yield self._topic(name, part), b"".join(part.encode(content))

    def _topic(self, name: str, definition: MessageDefinition[Any]) -> RecordedTopic:
        key = name, definition.name
        if key not in self._topics:
            self._topics[key] = _for_ros(name, topic_of(self._robot, definition), definition)
        return self._topics[key]


def _for_ros(name: str, topic: RecordedTopic, definition: MessageDefinition[Any]) -> RecordedTopic:
    """A topic under another name, with the metadata that rosbag2 reads."""
    metadata = {**topic.metadata, QOS: quality(definition)}
    if hashed := type_hash(topic.schema_name):
        metadata[TYPE_HASH] = hashed
    return dataclasses.replace(topic, name=name, metadata=metadata)


def quality(definition: MessageDefinition[Any]) -> str:
    """A message's quality of service, in the words of ROS 2."""
    latched = definition.rate_hz == 0.0 and definition.keep is Keep.NEWEST
    latched = latched and definition.plane is Plane.STATE and definition.name not in _ANSWERS
    return "\n".join(
        (
            "- history: keep_last",
            "  depth: 10",
            "  reliability: reliable",
            f"  durability: {'transient_local' if latched else 'volatile'}",
            f"  deadline:\n{_LONGEST}",
            f"  lifespan:\n{_LONGEST}",
            "  liveliness: automatic",
            f"  liveliness_lease_duration:\n{_LONGEST}",
            "  avoid_ros_namespace_conventions: false",
        )
    )


_ANSWERS = frozenset(each.name for each in (ODOMETRY, SCAN, CAMERA, PICTURE, MARKS, IMAGE))
