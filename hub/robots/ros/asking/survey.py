"""Looks at a robot with ROS through its line: topics, one message of each part, parameters.

| state | event | next |
| --- | --- | --- |
| waiting | the line is up | look |
| waiting | the host refuses connections for 1.5 s, or the time is over | the end |
| looking | after 0.7 s, since lines learn of nodes one by one | parameters are asked for |
| looking | the graph changes | topics of possible parts are subscribed to |
| looking | a message of a slow or large topic | that topic is left |
| looking | the robot's URDF names meshes | they are fetched, one after the other |
| looking | all parts and meshes were seen, and the parameters; or the time is over | the end |

Nothing is sent that moves the robot. The topic of velocities is advertised, to learn whether the
bridge takes messages, and given up again.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import time
from collections.abc import Mapping, Sequence
from typing import Final

from hub.errors import RosSilentError
from hub.plain_text import is_plain
from hub.robots.refusals import REFUSED_S
from hub.robots.ros.address import RosAddress
from hub.robots.ros.asking.findings import HeardTopic, RosFindings
from hub.robots.ros.asking.limits import description
from hub.robots.ros.asking.parts import TRANSFORMS, parts_of
from hub.robots.ros.asking.robots import namespaces_of
from hub.robots.ros.line import Payload, RosLine, RosMessage
from hub.robots.ros.line_loop import LineLoop
from hub.robots.ros.topic_reader import TopicReader
from hub.robots.urdf import meshes_named
from hub.ros.frame_tree import FrameTree
from hub.ros.values import RosValue

ROOT: Final = "/"
"""Stands for the robot without a namespace, among others."""
_LEAST_S: Final = 2.0
"""Time in which a robot shows what it has, and how often [s]."""
_NODES_S: Final = 3.5
"""The same where the line does not say yet which nodes publish and subscribe [s]."""
_GRAPH_S: Final = 0.7
"""Time in which a line learns of most nodes; only those can be asked for parameters [s]."""
_PARAMETERS_S: Final = 4.0
_AGAIN_S: Final = 0.2
_PAUSE_S: Final = 0.01
_MOST_TOPICS: Final = 64
_MOST_BYTES: Final = 1 << 25
"""Longest message that is read [bytes]: a picture, a map, a description of the robot."""
_FILE_S: Final = 10.0
"""Longest wait for a file [s]."""
_MOST_FILES: Final = 64
_MOST_FILE_BYTES: Final = 1 << 27
"""Size of fetched files after which no more are asked for [bytes]; the last may exceed it."""
_LONGEST_NAME: Final = 500
_MOST_CAMERAS: Final = 8
_MOST_TREES: Final = 8
_MOST_ODOMETRIES: Final = 4
_RATED: Final = ("nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/Range")


class RosSurvey:
    """A look at one robot; `findings` says what was found so far.

    Attributes:
        begun: When the line was first up [s, monotonic]; infinite: it never was.
    """

    def __init__(
        self, line: RosLine, address: RosAddress, namespace: str = "", also: Sequence[str] = ()
    ) -> None:
        """Look through a line.

        Args:
            line: It is not closed here.
            address: Where the robot is.
            namespace: Only what is below this name counts; empty: all does; `ROOT`: what is below
                that of no other robot.
            also: Further topics to listen to.
        """
        self._line, self._address, self._namespace = line, address, namespace
        self._also = tuple(also)
        self._reader = TopicReader(line)
        self._frames = FrameTree()
        self._read: dict[str, list[float]] = {}
        self._values: dict[str, RosValue] = {}
        self._ages: dict[str, float] = {}
        self._parameters: Mapping[str, object] | None = None
        self._files: dict[str, bytes | str] = {}
        self._fetching = self._described = ""
        self._meshes: tuple[str, ...] = ()
        self._asked = self._takes = False
        self._command = ""
        self.begun = math.inf
        self._due = -math.inf

    @property
    def findings(self) -> RosFindings:
        """What was found."""
        found = RosFindings(
            address=self._address,
            graph=self._line.graph,
            heard={name: self._heard(name, arrived) for name, arrived in self._read.items()},
            frames=self._frames,
            parameters=self._parameters or {},
            files=self._files,
            takes=self._takes,
            notes=self._line.state.notes,
            refusals=dict(self._line.state.refusals),
            namespace=self._namespace if self._namespace != ROOT else "",
        )
        if self._namespace != ROOT:
            return found
        others = tuple(each for each in namespaces_of(found) if each)
        return dataclasses.replace(found, others=others)

    def advance(self, now: float) -> bool:
        """Look on; returns whether all was seen [s, monotonic]."""
        self._line.advance(now)
        if not self._line.state.up:
            return False
        self.begun = min(self.begun, now)
        if not self._asked and now - self.begun >= _GRAPH_S:
            self._asked = True
            self._line.ask_parameters((), self._learn, _PARAMETERS_S)
        if now >= self._due:
            self._due = now + _AGAIN_S
            self._follow()
        return self._is_whole(now)

    def end(self) -> None:
        """Give up the topic of velocities."""
        if self._command:
            self._line.unadvertise(self._command)

    def _is_whole(self, now: float) -> bool:
        quiet = (name for name, arrived in self._read.items() if not arrived)
        explained = self._reader.faults.keys() | self._line.state.refusals.keys()
        waits = any(name not in explained for name in quiet)
        least = _LEAST_S if self._line.graph.whole else _NODES_S
        seen = bool(self._line.graph.topics) and self._parameters is not None
        if now - self.begun < least or not seen or waits:
            return False
        self._fetch()
        return not self._fetching

    def _learn(self, parameters: Mapping[str, object]) -> None:
        self._parameters = parameters

    def _follow(self) -> None:
        """Read the topics of possible parts, and try to be a publisher of velocities."""
        found = self.findings
        parts = parts_of(found)
        if parts.command is not None and parts.command.name != self._command:
            self.end()
            self._command = parts.command.name
            self._line.advertise(self._command, parts.command.schema_name)
        self._takes = bool(self._command and self._line.encoding(self._command))
        trees = [each.name for each in found.published(TRANSFORMS)]
        texts = [each.name for each in found.published("std_msgs/String")]
        cameras = parts.cameras[:_MOST_CAMERAS]
        wanted = (
            *(name for name in self._also if name in found.graph.topics),
            *(parts.odometry, *parts.odometries[: _MOST_ODOMETRIES - 1]),
            *trees[:_MOST_TREES],
            *(name for name in texts if name.endswith("/robot_description")),
            *parts.single.values(),
            *(name for each in cameras for name in (each.pictures, each.info)),
            *parts.scans,
            *parts.ranges,
        )
        for name in wanted:
            if name and name not in self._read and len(self._read) < _MOST_TOPICS:
                self._read[name] = []
                self._reader.read(name, self._take, each=True, most=_MOST_BYTES)

        self._fetch()

    def _fetch(self) -> None:
        """Ask for the next mesh of the robot's URDF, if none is under way."""
        if self._fetching:
            return
        text = description(self.findings)
        if text != self._described:
            self._described, self._meshes = text, meshes_named(text)
        for name in self._meshes:
            if self._fetching:  # else the line refused the one before at once
                return
            if name in self._files:
                continue
            size = sum(map(len, self._files.values()))
            if len(self._files) >= _MOST_FILES or size > _MOST_FILE_BYTES:
                self._files[name] = f"it has too many, or too large ones ({size} bytes before it)"
            elif len(name) > _LONGEST_NAME or not is_plain(name):
                self._files[name] = "its name is too long, or no text"
            else:
                self._fetching = name
                self._line.fetch(name, functools.partial(self._keep, name), _FILE_S)

    def _keep(self, name: str, content: Payload | None, why: str) -> None:
        """Keep a file, or the reason why there is none."""
        self._fetching = ""
        self._files[name] = why if content is None else bytes(content)

    def _take(self, value: RosValue, message: RosMessage) -> None:
        name, kind = message.topic.name, message.topic.schema_name
        if kind == "tf2_msgs/msg/TFMessage":
            self._frames.take(value)
            self._read[name] = [message.arrived]
            return
        self._values[name], self._ages[name] = value, message.age
        arrived = self._read[name]
        arrived.append(message.arrived)
        if kind not in _RATED or len(arrived) > 1000:
            self._line.unsubscribe(name)

    def _heard(self, name: str, arrived: list[float]) -> HeardTopic:
        span = arrived[-1] - arrived[0] if arrived else 0.0
        return HeardTopic(
            messages=len(arrived),
            rate_hz=(len(arrived) - 1) / span if span > 0.0 else math.nan,
            age=self._ages.get(name, math.nan),
            value=self._values.get(name),
            fault=self._reader.faults.get(name) or self._line.state.refusals.get(name, ""),
        )


def look_at(
    loop: LineLoop,
    address: RosAddress,
    seconds: float,
    *,
    namespace: str = "",
    also: Sequence[str] = (),
) -> RosFindings:
    """Look at a robot.

    Args:
        loop: The loop of a line to it.
        address: Where it is.
        seconds: Longest time for a connection, and then for its messages [s].
        namespace: As in `RosSurvey`.
        also: Further topics to listen to.

    Raises:
        RosSilentError: Nothing answers.
    """
    line = loop.line
    survey = RosSurvey(line, address, namespace, also)
    end = time.monotonic() + seconds
    while not survey.advance(now := time.monotonic()):
        if survey.begun < math.inf:
            end = survey.begun + seconds
        if now > end or now - line.state.refused_since >= REFUSED_S:
            break
        loop.wait(_PAUSE_S)
    if survey.begun == math.inf:
        why = line.state.why or "there is no answer; start its bridge or router"
        text = f"no robot with ROS answers at {address.text}: {why}"
        raise RosSilentError(text)
    found = survey.findings
    survey.end()
    line.advance(time.monotonic())
    return found
