"""What Rune makes of a robot with ROS, and what its owner has to know; pure."""

from __future__ import annotations

import functools
import ipaddress
import math
import re
from collections.abc import Iterator
from typing import Final

from hub.plain_text import counted, plain
from hub.robots.ros.address import RosAddress, RosLineKind
from hub.robots.ros.asking import limits, tables
from hub.robots.ros.asking.findings import RosFindings, is_name, plain_type
from hub.robots.ros.asking.limits import RosLimits
from hub.robots.ros.asking.parts import READ, RosParts, parts_of
from hub.robots.ros.asking.robots import namespaces_of
from hub.robots.ros.asking.stopping import Stopping, stopping
from hub.robots.ros.asking.tables import BodyTables
from hub.robots.ros.goals.goal_actions import driving_nodes
from hub.robots.ros.line import RosTopic
from hub.robots.ros.odometry import odometry_fault
from hub.robots.ros.own_nodes import foreign
from hub.robots.ros.topic_reader import UNFIT
from hub.robots.urdf import UrdfModel
from hub.ros.battery import counts_to_100
from hub.values import dataclass

_MOST_NAMED: Final = 4
_MOST_DOUBTS: Final = 12
_LIGHT: Final = re.compile(r"light|led|lamp", re.IGNORECASE)
_HEAD: Final = re.compile(r"(?:^|_|/)(?:pan|tilt)(?:_|/|$)")
_NUMBER_TYPES: Final = ("std_msgs/Float64", "std_msgs/Float32", "std_msgs/Float64MultiArray")
_BRIDGE_ADDRESS: Final = re.compile(r".*foxglove_bridge[./]address")
_BRIDGE_TLS: Final = re.compile(r".*foxglove_bridge[./]tls")


@dataclass(frozen=True, slots=True, kw_only=True)
class Danger:
    """Something that makes it unsafe to drive.

    Attributes:
        name: Short, for programs.
        why: A sentence.
    """

    name: str
    why: str


class RosProposal:
    """A robot as Rune would drive it.

    Attributes:
        found: What was found.
        parts: Its topics.
        stopping: What stops it.
        limits: How fast it may be driven.
    """

    def __init__(self, found: RosFindings) -> None:
        self.found = found
        self.parts: RosParts = parts_of(found)
        self.stopping: Stopping = stopping(found, self.parts.command)
        self.limits: RosLimits = limits.limits(found)

    @functools.cached_property
    def tables(self) -> BodyTables:
        """Its sensors and cameras."""
        return tables.tables_of(self.found, self.parts)

    @functools.cached_property
    def outline(self) -> tuple[UrdfModel | None, str]:
        """Its URDF, or None; why its outline is not known, empty: it is, or it has no URDF."""
        return limits.model(self.found)

    @property
    def radius(self) -> float:
        """The radius that its own planner has [m]; NaN: not known."""
        return limits.radius(self.found)

    @property
    def base_frame(self) -> str:
        """The frame of its base."""
        return tables.base_frame(self.found, self.parts)

    @property
    def hold(self) -> bool:
        """Whether zeros have to go on while it stands, because it may keep its last velocity."""
        return not self.stopping.seconds < math.inf

    @property
    def title(self) -> str:
        """What it is: "robot with ROS 2 (jazzy)"."""
        graph = self.found.graph
        named = f" ({plain(graph.distribution)[:20]})" if graph.distribution else ""
        return f"robot with ROS {graph.version}{named}"

    @property
    def name(self) -> str:
        """A name for it."""
        return limits.name_of(self.found) or "ros-robot"

    @property
    def battery_percent(self) -> bool:
        """Whether its battery counts to 100, not to 1."""
        value = self.found.of(self.parts.single["battery"]).value
        try:
            return value is not None and counts_to_100(value)
        except UNFIT:
            return False

    def lights(self) -> dict[str, str]:
        """Topics and services that switch lights, by a name for each."""
        found = self.found
        topics = [
            each.name
            for each in found.topics_of("std_msgs/Bool", *_NUMBER_TYPES)
            if _LIGHT.search(each.name) and (foreign(each.subscribers) or not found.graph.whole)
        ]
        services = [
            each.name
            for each in found.graph.services.values()
            if plain_type(each.type) == "std_srvs/SetBool"
            and _LIGHT.search(each.name)
            and found.counts(each.name)
        ]
        return _named(sorted((*topics, *services)))

    def joints(self) -> dict[str, str]:
        """Topics that turn a pan or tilt joint, by the joint's name."""
        value = self.found.of(self.parts.single["joints"]).value
        known = value.field("name") if value is not None else ()
        made: dict[str, str] = {}
        for name in (known if isinstance(known, tuple | list) else ())[:1000]:
            if not isinstance(name, str) or not _HEAD.search(name) or not is_name(f"/{name}"):
                continue
            bare = name.removesuffix("_joint")
            for topic in self.found.topics_of(*_NUMBER_TYPES):
                takes = foreign(topic.subscribers) or not self.found.graph.whole
                if bare in topic.name and takes and len(name) <= 32:
                    made.setdefault(name, topic.name)
        return made

    def dangers(self) -> Iterator[Danger]:
        """What makes it unsafe to drive."""
        found, command = self.found, self.parts.command
        if command is not None and not self.stopping.safe:
            yield Danger(name="time-out", why=self._without_time_out())
        name = self.parts.navigation.name if self.parts.navigation is not None else ""
        own = driving_nodes(found.graph, name)
        others = foreign(command.publishers) if command is not None else ()
        if command is not None and (more := tuple(each for each in others if each not in own)):
            text = f"{_listed(more)} also publishes {command.name}: the robot follows the newest"
            yield Danger(name="publisher", why=text)
        if open_way := open_way_of(found):
            yield Danger(name="network", why=open_way)

    def _without_time_out(self) -> str:
        if self.hold:
            return (
                f"{self.stopping.words}. If this hub or the line ends while it drives, "
                f"{'perhaps ' * math.isnan(self.stopping.seconds)}nothing stops it. Set a time-out "
                "in the robot. Until then Rune repeats the zero while it stands: `hold = true`"
            )
        return f"{self.stopping.words}, which is long; set it to 0.5 in the robot"

    def refusal(self) -> str:
        """Why it cannot be driven at all, in a sentence; empty: it can."""
        found, command = self.found, self.parts.command
        if not found.graph.topics:
            return "it has no topics: no node runs, or its bridge hides all of them"
        if len(names := namespaces_of(found)) > 1:
            listed = _listed(tuple(each or "/" for each in names))
            return f"{len(names)} robots: {listed}; choose one with --namespace"
        if command is None:
            return "no topic of it takes velocities (geometry_msgs Twist or TwistStamped)"
        if not found.takes:
            return (
                "its bridge takes no messages: give it the capability clientPublish, and "
                f"{command.name} in client_topic_whitelist"
            )
        if refused := refused_command(found, command):
            return refused
        if not self.parts.odometry and not self.parts.transforms:
            return "it has no odometry and no frames: nothing says where it is"
        return ""

    def remarks(self) -> Iterator[str]:
        """What the owner has to know, a sentence each; dangers first."""
        if refusal := self.refusal():
            yield f"it cannot be driven: {refusal}"
        for danger in self.dangers():
            yield f"unsafe: {danger.why}"
        yield from (plain(note)[:300] for note in self.found.notes)
        yield from self._commands()
        yield from self._places()
        doubts = self.tables.doubts
        yield from doubts[:_MOST_DOUBTS]
        if len(doubts) > _MOST_DOUBTS:
            more = len(doubts) - _MOST_DOUBTS
            yield f"{more} more sensors are not used, or their place is not known"
        if self.battery_percent:
            yield "its battery counts to 100, where ROS has 0 to 1: `battery_percent = true`"
        model, fault = self.outline
        if fault:
            yield f"its outline is not known: {plain(fault)[:300]}"
        elif model is not None and model.moved_by:
            joints = f"{_listed(model.moved_by)} at zero"
            yield f"its outline has {joints}: if it reaches farther, correct `footprint`"
        parameters = self.found.parameters.items()
        if any(name.endswith("use_sim_time") and value is True for name, value in parameters):
            yield "it runs on simulated time: it is a simulation, or replays a recording"
        yield from self._rest()

    def _commands(self) -> Iterator[str]:
        command, parts = self.parts.command, self.parts
        if command is None:
            return
        if self.stopping.safe:
            yield self.stopping.words
        if parts.assumed:
            yield f"the bridge does not say the type of {command.name}: {parts.assumed}"
        if self.found.graph.whole and not foreign(command.subscribers):
            yield f"no node subscribes to {command.name}: the robot will not move"
        if parts.commands:
            yield (
                f"{command.name} takes the velocities; {_listed(parts.commands)} would too: "
                "correct `cmd_vel` if another one is right"
            )
        if parts.navigation is not None:
            yield (
                f"its own navigation {parts.navigation.name} drives to goals, at its own speed: "
                "it goes on to a goal when this hub or the line to it ends"
            )
        if not self.limits.known:
            yield (
                f"it does not say how fast it may be, so at most {self.limits.linear:g} m/s: raise "
                "[limits] in its robot file once you have seen it drive"
            )

    def _places(self) -> Iterator[str]:
        parts, found = self.parts, self.found
        if not parts.odometry:
            if parts.transforms:
                yield f"it has no odometry: its place comes from {parts.transforms}"
            return
        heard = found.of(parts.odometry)
        if heard.value is None:
            yield f"{parts.odometry}: {plain(heard.fault)[:200] or 'nothing came on it'}"
        elif fault := odometry_fault(heard.value):
            yield f"it cannot be driven until {parts.odometry} is right: {plain(fault)[:200]}"
        if parts.odometries:
            yield f"{parts.odometry} is its odometry; others are {_listed(parts.odometries)}"

    def _rest(self) -> Iterator[str]:
        """What is left over."""
        graph = self.found.graph
        taken = {*self.parts.taken, *self.lights().values(), *self.joints().values()}
        strange = [name for name in graph.topics if not is_name(name)]
        if strange:
            yield f"{counted(len(strange), 'topic')} with names that ROS does not allow is not used"
        left = [
            f"{topic.name} ({plain_type(topic.schema_name)[:60]})"
            for topic in graph.topics.values()
            if topic.schema_name
            and topic.name not in taken
            and is_name(topic.name)
            and plain_type(topic.schema_name) not in READ
        ]
        if left:
            yield f"not understood: {_listed(tuple(sorted(left)))}"


def refused_command(found: RosFindings, command: RosTopic) -> str:
    """Why the bridge does not publish the velocities, and what to do; empty: it does."""
    words = found.refusals.get(command.name)
    if words is None:
        return ""
    package = plain_type(command.schema_name).partition("/")[0] or "geometry_msgs"
    return (
        f"its bridge cannot publish {command.name}: install {plain(package)[:64]} where the bridge "
        f"runs, and start the bridge again. It says: {plain(words)[:200]}"
    )


def open_way_of(found: RosFindings) -> str:
    """Why others can drive it too; empty: nothing shows that they can."""
    address = found.address
    remedy = "start the bridge with address:=127.0.0.1, and use --ssh USER@ROBOT"
    if address.kind is RosLineKind.ZENOH:
        if address.secure or on_loopback(address):
            return ""
        return (
            f"anybody in this network can drive it by its router at {address.host}: "
            "use zenoh+tls with --tls FOLDER, or ssh"
        )
    everywhere = any(
        _BRIDGE_ADDRESS.fullmatch(name) and value in ("0.0.0.0", "::", "")
        for name, value in found.parameters.items()
    )
    tls = address.secure or any(
        _BRIDGE_TLS.fullmatch(name) and value is True for name, value in found.parameters.items()
    )
    if tls or (on_loopback(address) and not everywhere):
        return ""
    return f"anybody in this network can drive it by its bridge: {remedy}"


def on_loopback(address: RosAddress) -> bool:
    """Whether an address is within this machine."""
    try:
        return ipaddress.ip_address(address.host).is_loopback
    except ValueError:
        return address.host == "localhost"


def _listed(names: tuple[str, ...]) -> str:
    """Some names, and how many more there are."""
    more = len(names) - _MOST_NAMED
    shown = ", ".join(plain(name)[:120] for name in names[:_MOST_NAMED])
    return f"{shown} and {more} more" if more > 0 else shown


def _named(topics: list[str]) -> dict[str, str]:
    """A short name for each topic."""
    made: dict[str, str] = {}
    for topic in topics[:16]:
        words = [word for word in topic.strip("/").split("/") if word not in ("cmd", "set")]
        name = (words[-1] if words else "light").replace("_", " ")[:28].strip() or "light"
        number = 1
        while name in made:
            number += 1
            name = f"{name.rstrip('0123456789 ')} {number}"
        made[name] = topic
    return made
