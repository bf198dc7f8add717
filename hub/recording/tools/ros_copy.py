"""Copies for the tools of ROS 2: topics as they name them, and the metadata of a bag's folder."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from hub import files
from hub.errors import RecordingError
from hub.gcm.catalog import BY_NAME
from hub.ipc.definition import MessageDefinition
from hub.recording.chunks import LoggedMessage
from hub.recording.live.ros_names import RosTopics
from hub.recording.new_recording import NewRecording
from hub.recording.ros.metadata import METADATA
from hub.recording.ros_quality import QOS, TYPE_HASH, VERSION, numbered
from hub.recording.topics import RecordedTopic, topic_of

_SHARED: Final = ("/tf", "/tf_static")
"""Topics that all robots have in common."""


class RosCopy:
    """Writes messages under the names that ROS 2 has for them.

    Messages of Rune whose definition has changed since keep their names, as do those that were
    recorded with names of ROS 2. Where several robots are recorded, the name of each stands before
    its topics, but those of transforms.

    Attributes:
        counts: Number of messages by topic.
        start: Stamp of the first message [ns].
        end: Stamp of the last [ns].
    """

    def __init__(self, new: NewRecording, topics: Mapping[int, RecordedTopic]) -> None:
        self.counts: Counter[RecordedTopic] = Counter()
        self.start = self.end = -1
        self._new, self._topics = new, topics
        self._several = len({topic.robot for topic in topics.values() if _definition(topic)}) > 1
        self._spaced: dict[tuple[str, str], RecordedTopic] = {}
        self._robots: dict[str, RosTopics] = {}
        self._named: dict[int, tuple[RecordedTopic, MessageDefinition[Any] | None]] = {}

    def add(self, message: LoggedMessage) -> None:
        """Write a message, and the messages of ROS 2 that it holds."""
        if message.channel not in self._named:
            self._named[message.channel] = self._name(self._topics[message.channel])
        named, definition = self._named[message.channel]
        self._write(named, message, message.payload)
        if definition is not None:
            robot = self._topics[message.channel].robot
            for part, payload in self._robots[robot].translated(definition, message.payload):
                self._write(self._of_robot(robot, part), message, payload)

    def _name(self, topic: RecordedTopic) -> tuple[RecordedTopic, MessageDefinition[Any] | None]:
        """The topic in the copy, and the definition of a message of the hub as it is now."""
        definition = _definition(topic)
        if definition is None:
            return topic, None
        robot = self._robots.setdefault(topic.robot, RosTopics(topic.robot))
        return self._of_robot(topic.robot, robot.named(definition, topic)), definition

    def _of_robot(self, robot: str, topic: RecordedTopic) -> RecordedTopic:
        """The topic within the names of its robot, if there are several robots."""
        if not self._several or topic.name in _SHARED or topic.name.startswith(f"/{robot}/"):
            return topic
        key = robot, topic.name
        if key not in self._spaced:
            self._spaced[key] = dataclasses.replace(topic, name=f"/{robot}{topic.name}")
        return self._spaced[key]

    def _write(self, topic: RecordedTopic, message: LoggedMessage, payload: bytes) -> None:
        self._new.add(topic, message.stamp, message.published, message.number, payload)
        self.counts[topic] += 1
        self.start = message.stamp if self.start < 0 else self.start
        self.end = message.stamp


def _definition(topic: RecordedTopic) -> MessageDefinition[Any] | None:
    """The definition of a message of the hub, if the recording has the present one.

    None too in a recording that has names of ROS 2: what the message holds is there already.
    """
    definition = BY_NAME.get(topic.message)
    if definition is None or not topic.robot or QOS in topic.metadata:
        return None
    return definition if topic_of(topic.robot, definition).schema == topic.schema else None


def write_bag_metadata(folder: Path, name: str, copy: RosCopy) -> None:
    """Write the file that makes a folder with one MCAP file a bag of rosbag2.

    Raises:
        RecordingError: It cannot be written.
    """
    start, length = max(0, copy.start), max(0, copy.end - copy.start)
    span = (
        f"duration:\n{{0}}  nanoseconds: {length}\n"
        f"{{0}}starting_time:\n{{0}}  nanoseconds_since_epoch: {start}\n"
        f"{{0}}message_count: {copy.counts.total()}\n"
    )
    lines = [
        "rosbag2_bagfile_information:\n",
        f"  version: {VERSION}\n",
        "  storage_identifier: mcap\n",
        "  " + span.format("  "),
        "  topics_with_message_count:" + ("\n" if copy.counts else " []\n"),
    ]
    for topic, count in sorted(copy.counts.items(), key=lambda each: each[0].name):
        quality = numbered(topic.metadata.get(QOS, ""))
        lines += [
            "    - topic_metadata:\n",
            f"        name: {json.dumps(topic.name)}\n",
            f"        type: {json.dumps(topic.schema_name)}\n",
            f"        serialization_format: {json.dumps(topic.encoding)}\n",
            f"        offered_qos_profiles: {json.dumps(quality)}\n",
            f"        type_description_hash: {json.dumps(topic.metadata.get(TYPE_HASH, ''))}\n",
            f"      message_count: {count}\n",
        ]
    lines += [
        '  compression_format: ""\n  compression_mode: ""\n',
        f"  relative_file_paths:\n    - {json.dumps(name)}\n",
        f"  files:\n    - path: {json.dumps(name)}\n      " + span.format("      "),
    ]
    try:
        files.replace(folder / METADATA, "".join(lines).encode())
    except OSError as error:
        text = f"{folder / METADATA} cannot be written: {error.strerror}"
        raise RecordingError(text) from error
