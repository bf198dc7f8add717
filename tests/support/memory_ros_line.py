"""A line to a robot with ROS that is only in memory: the hardware edge of what stands on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_typestore

from hub.ipc.definition import MessageDefinition
from hub.robots.description import RobotDescription
from hub.robots.interfaces import FileLoop
from hub.robots.robot_file import read_description
from hub.robots.ros.line import (
    RosGraph,
    RosLineState,
    RosMessage,
    RosService,
    RosTopic,
    TakeAnswer,
    TakeParameters,
)
from hub.values import dataclass

ROS1 = get_typestore(Stores.ROS1_NOETIC)


@dataclass(kw_only=True)
class MemoryLine:
    """Implements `RosLine`; a test sets its state and gives it messages."""

    state: RosLineState = RosLineState(up=True, connections=1, heard=0.0)
    topics: dict[str, RosTopic] = field(default_factory=dict)
    services: dict[str, RosService] = field(default_factory=dict)
    whole: bool = False
    takers: dict[str, Callable[[RosMessage], None]] = field(default_factory=dict)
    advertised: dict[str, str] = field(default_factory=dict)
    published: list[tuple[str, bytes]] = field(default_factory=list)
    called: list[tuple[str, bytes, Callable[..., None]]] = field(default_factory=list)
    reconnects: list[str] = field(default_factory=list)
    encodings: str = "cdr"
    full: bool = False
    files: dict[str, bytes] = field(default_factory=dict)
    fetched: list[str] = field(default_factory=list)

    @property
    def graph(self) -> RosGraph:
        return RosGraph(topics=self.topics, services=self.services, whole=self.whole)

    def topic(self, name: str, kind: str, **more: Any) -> RosTopic:
        """Let the robot have a topic."""
        made = RosTopic(name=name, schema_name=kind, encoding=self.encodings, **more)
        if self.encodings == "ros1":
            text, _ = ROS1.generate_msgdef(kind, ros_version=1)
            made = RosTopic(
                name=name,
                schema_name=kind,
                encoding="ros1",
                schema_encoding="ros1msg",
                schema=text.encode(),
            )
        self.topics[name] = made
        return made

    def give(self, name: str, payload: Any, now: float, age: float = 0.0, time_ns: int = 0) -> None:
        """Let a message arrive."""
        if name in self.takers:
            topic = self.topics[name]
            message = RosMessage(
                payload=payload, topic=topic, arrived=now, age=age, time_ns=time_ns
            )
            self.takers[name](message)

    def lose(self, why: str = "it closed") -> None:
        self.state = RosLineState(up=False, connections=self.state.connections, heard=0.0, why=why)

    def find(self) -> None:
        self.state = RosLineState(up=True, connections=self.state.connections + 1, heard=0.0)

    def sent(self, name: str) -> list[bytes]:
        """What was published on a topic since the last call."""
        found = [payload for topic, payload in self.published if topic == name]
        self.published = [each for each in self.published if each[0] != name]
        return found

    def subscribe(self, topic: str, take: Callable[[RosMessage], None]) -> None:
        self.takers[topic] = take

    def unsubscribe(self, topic: str) -> None:
        self.takers.pop(topic, None)

    def advertise(self, topic: str, type_name: str) -> None:
        self.advertised[topic] = type_name

    def unadvertise(self, topic: str) -> None:
        self.advertised.pop(topic, None)

    def encoding(self, topic: str) -> str:
        return self.encodings if topic in self.advertised else ""

    def publish(self, topic: str, payload: bytes, *, late: bool = False) -> bool:
        if not self.state.up or (self.full and not late):
            return False
        assert topic in self.advertised
        self.published.append((topic, payload))
        return True

    def call(
        self, service: str, payload: bytes, answered: Callable[..., None], _timeout: float
    ) -> None:
        self.called.append((service, payload, answered))

    def ask_parameters(
        self, _names: tuple[str, ...], answered: TakeParameters, _timeout: float
    ) -> None:
        answered({})

    def fetch(self, name: str, answered: TakeAnswer, _timeout: float) -> None:
        self.fetched.append(name)
        found = self.files.get(name)
        answered(found, "" if found is not None else "there is no such file")

    def reconnect(self, why: str) -> None:
        self.reconnects.append(why)
        self.find()

    def advance(self, now: float) -> None:
        """Nothing waits here."""

    def watch(self, loop: FileLoop, work: Callable[[], None]) -> None:
        """There is no file."""

    def close(self) -> None:
        self.lose()


def cdr(value: Any) -> bytes:
    """A message of Rune whose type is one of ROS 2, as its payload."""
    return b"".join(MessageDefinition(name="Ros_Test", type=type(value)).encode(value))


def ros_robot(tmp_path: Path, more: str = "") -> RobotDescription:
    """A robot file of the kind `ros` with further keys and tables."""
    path = tmp_path / "robot.toml"
    path.write_text(f'name = "turtle"\nkind = "ros"\n{more}\n[modules.driver]\nrun = "a"\n')
    robot, problems = read_description(path)
    assert not problems
    return robot
