"""What a line to a robot with ROS offers; how it gets there, each kind of line knows.

A line never waits: it belongs to one thread, which calls `advance`. What is subscribed to and
advertised outlives a lost connection: the line asks for it again on the next one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Final, Protocol

from hub.robots.interfaces import FileLoop
from hub.values import dataclass

Payload = bytes | memoryview
TakeAnswer = Callable[[Payload | None, str], None]
"""Takes the answer of a service, or a file, and ""; or None and the reason why there is none."""
TakeParameters = Callable[[Mapping[str, object]], None]
"""Takes the parameters that there are, perhaps none."""

_ROS_1: Final = ("noetic", "melodic", "kinetic", "lunar")


@dataclass(frozen=True, slots=True, kw_only=True)
class RosTopic:
    """A topic that a robot has, as `RosDecoder.of` takes it.

    Attributes:
        name: Such as "/odom".
        schema_name: Its type as ROS 2 writes it, such as "nav_msgs/msg/Odometry"; empty: not known.
        encoding: The encoding of its messages: "cdr" or "ros1"; empty: not known.
        schema_encoding: The encoding of its definition: "ros2msg", "ros2idl", "ros1msg"; empty: it
            is known by its name.
        schema: Its definition; empty: the robot does not give it.
        publishers: Names of the nodes that publish it, where the line knows them.
        subscribers: Names of the nodes that subscribe to it, where the line knows them.
    """

    name: str
    schema_name: str = ""
    encoding: str = ""
    schema_encoding: str = ""
    schema: bytes = b""
    publishers: tuple[str, ...] = ()
    subscribers: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class RosService:
    """A service that a robot has.

    Attributes:
        name: Such as "/e_stop".
        type: Its type as ROS 2 writes it, such as "std_srvs/srv/Trigger".
        encoding: The encoding of its requests: "cdr" or "ros1"; empty: not known.
    """

    name: str
    type: str
    encoding: str = "cdr"


@dataclass(frozen=True, slots=True, kw_only=True)
class RosGraph:
    """The topics and services of a robot's nodes, as far as they are known.

    Attributes:
        distribution: Such as "jazzy"; empty: not known.
        topics: By name; also those that are only subscribed to.
        services: By name.
        whole: Whether publishers and subscribers are known.
    """

    distribution: str = ""
    topics: Mapping[str, RosTopic]
    services: Mapping[str, RosService]
    whole: bool = False

    @property
    def version(self) -> int:
        """Of ROS: 1 or 2."""
        old = any(topic.encoding == "ros1" for topic in self.topics.values())
        return 1 if old or self.distribution in _ROS_1 else 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RosMessage:
    """A received message.

    Attributes:
        payload: Its bytes, in the encoding of its topic; a view is valid during the call only.
        topic: Its topic.
        arrived: When it was received [s, monotonic].
        age: For how long it was on its way from the robot's middleware to here [s], at least 0;
            NaN: not known.
        time_ns: When it was in the robot's middleware, by a clock of the robot [ns]; 0: not known.
    """

    payload: Payload
    topic: RosTopic
    arrived: float
    age: float
    time_ns: int = 0

    @property
    def measured(self) -> float:
        """When it left the robot's middleware [s, monotonic], as far as its age is known."""
        return self.arrived - (self.age if math.isfinite(self.age) else 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class RosLineState:
    """What a line does.

    Attributes:
        up: Whether messages can pass.
        why: The last fault in words; empty: there was none.
        refused_since: Since when its host refuses connections [s, monotonic]; inf: it does not.
        connections: How often it was made.
        heard: When anything was last received [s, monotonic]; -inf: never.
        dropped: Messages that could not leave at once.
        faults: Messages of the other end that made no sense.
        notes: What the other end said of itself, the newest sentences.
        refusals: Why it does not serve a topic or a service that is used here, in its own words,
            by the name of it.
    """

    up: bool
    why: str = ""
    refused_since: float = math.inf
    connections: int = 0
    heard: float
    dropped: int = 0
    faults: int = 0
    notes: tuple[str, ...] = ()
    refusals: Mapping[str, str] = field(default_factory=dict)


class RosLine(Protocol):
    """A line to one robot."""

    @property
    def state(self) -> RosLineState:
        """What it does."""

    @property
    def graph(self) -> RosGraph:
        """The robot's topics and services, as far as they are known now."""

    def subscribe(self, topic: str, take: Callable[[RosMessage], None]) -> None:
        """Have each message of a topic from now on, as soon as the robot has the topic."""

    def unsubscribe(self, topic: str) -> None:
        """Have no more of them."""

    def advertise(self, topic: str, type_name: str) -> None:
        """Be a publisher of a topic from now on.

        Args:
            topic: Its name.
            type_name: Its type as ROS 2 writes it.
        """

    def unadvertise(self, topic: str) -> None:
        """Be one no more."""

    def encoding(self, topic: str) -> str:
        """The encoding that an advertised topic takes, "cdr" or "ros1"; empty: not known yet."""

    def publish(self, topic: str, payload: Payload, *, late: bool = False) -> bool:
        """Send a message of an advertised topic at once.

        A message that cannot leave now is dropped: an old velocity must not arrive late.

        Args:
            topic: The topic.
            payload: The message.
            late: Whether it may wait behind what the line holds, and arrive late.

        Returns:
            Whether it left, or waits.
        """

    def call(self, service: str, payload: Payload, answered: TakeAnswer, timeout: float) -> None:
        """Call a service.

        Args:
            service: Its name.
            payload: The request, in the encoding of the service.
            answered: Takes the answer.
            timeout: Longest time until then [s].
        """

    def ask_parameters(
        self, names: tuple[str, ...], answered: TakeParameters, timeout: float
    ) -> None:
        """Read parameters, such as "/diff_drive_controller.cmd_vel_timeout".

        Args:
            names: Their names; none: all.
            answered: Takes their values.
            timeout: Longest time until then [s].
        """

    def fetch(self, name: str, answered: TakeAnswer, timeout: float) -> None:
        """Read a file of the robot that its description names, such as "package://base/hull.stl".

        Args:
            name: As the description writes it.
            answered: Takes its content.
            timeout: Longest time until then [s].
        """

    def reconnect(self, why: str) -> None:
        """Drop the connection with all that waits in it, and make a new one at once."""

    def advance(self, now: float) -> None:
        """Connect if need be, receive, send what is due; never waits.

        Args:
            now: Monotonic time [s].
        """

    def watch(self, loop: FileLoop, work: Callable[[], None]) -> None:
        """Have a loop call `work` whenever there is something to read."""

    def close(self) -> None:
        """Leave."""
