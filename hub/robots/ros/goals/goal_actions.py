"""Where the parts of a robot's own navigation are, and whether a robot has them all; pure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub.plain_text import plain
from hub.robots.ros.line import RosGraph
from hub.ros.goal_messages import GET_RESULT, OLD_FEEDBACK, OLD_STATUS, SEND_GOAL
from hub.ros.schema import full_name
from hub.values import dataclass

_HIDDEN: Final = "/_action/"


_NODES_OF_NAV2: Final = (
    "behavior_server",
    "collision_monitor",
    "controller_server",
    "docking_server",
    "recoveries_server",
    "velocity_smoother",
)
"""Names of the nodes of Nav2 that publish velocities."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalEnds:
    """The topics and services of an action.

    Attributes:
        goal: Takes goals: a service of ROS 2, a topic of ROS 1.
        cancel: Takes cancels: a service of ROS 2, a topic of ROS 1.
        status: Topic with the states of all goals.
        feedback: Topic of a goal that goes on.
        result: Service that says how a goal ended; ROS 1 has none.
        old: Whether they are of ROS 1.
    """

    goal: str
    cancel: str
    status: str
    feedback: str
    result: str
    old: bool

    @classmethod
    def of(cls, name: str, *, old: bool) -> GoalEnds:
        """Those of the action of a name."""
        parts = ("goal", "cancel") if old else ("send_goal", "cancel_goal")
        base = f"{name}/" if old else f"{name}{_HIDDEN}"
        goal, cancel = (base + part for part in parts)
        return cls(
            goal=goal,
            cancel=cancel,
            status=f"{base}status",
            feedback=f"{base}feedback",
            result="" if old else f"{base}get_result",
            old=old,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalAction:
    """An action that takes goals.

    Attributes:
        name: Its name.
        ends: Its topics and services.
        explains: Whether it has the service that says why a goal failed.
    """

    name: str
    ends: GoalEnds
    explains: bool = False


def action_of(graph: RosGraph, name: str) -> GoalAction | None:
    """The action of a name, if the robot shows all its parts."""
    ends = GoalEnds.of(name, old=False)
    services = {key: graph.services[key].type for key in graph.services.keys() & {ends.goal}}
    heard = ends.status in graph.topics and ends.feedback in graph.topics
    if services == {ends.goal: SEND_GOAL} and ends.cancel in graph.services and heard:
        result = graph.services.get(ends.result)
        explains = result is not None and result.type == GET_RESULT
        return GoalAction(name=name, ends=ends, explains=explains)
    ends = GoalEnds.of(name, old=True)
    kinds = {ends.status: OLD_STATUS, ends.feedback: OLD_FEEDBACK}
    if all(_type(graph, topic) == kind for topic, kind in kinds.items()):
        return GoalAction(name=name, ends=ends)
    return None


def actions_of(graph: RosGraph) -> Iterator[GoalAction]:
    """All such actions of a robot, by name."""
    endings = (GoalEnds.of("", old=False).goal, GoalEnds.of("", old=True).status)
    for each in sorted({*graph.services, *graph.topics}):
        for ending in endings:
            found = action_of(graph, each.removesuffix(ending)) if each.endswith(ending) else None
            if found is not None:
                yield found


def driving_nodes(graph: RosGraph, name: str) -> frozenset[str]:
    """The nodes that drive to goals of the action of a name: no rivals of the hub that sends them.

    Args:
        graph: The robot's topics.
        name: The action; empty: there is none.
    """
    if not name:
        return frozenset()
    ends = (GoalEnds.of(name, old=old) for old in (False, True))
    topics = (graph.topics.get(each.status) for each in ends)
    nodes = (node for topic in topics if topic is not None for node in topic.publishers)
    base = name.rpartition("/")[0]
    return frozenset((*nodes, *(f"{base}/{each}" for each in _NODES_OF_NAV2)))


def missing_action(graph: RosGraph, name: str) -> str:
    """Why a robot does not have the action of a name, and the remedy."""
    ends = GoalEnds.of(name, old=False)
    kind = graph.services[ends.goal].type if ends.goal in graph.services else ""
    if kind not in ("", SEND_GOAL):
        return f"{name} is of type {plain(kind)[:80]}, not of {SEND_GOAL}"
    hidden = any(_HIDDEN in each for each in (*graph.services, *graph.topics))
    if kind or hidden:
        lacks = [each for each in (ends.goal, ends.cancel) if each not in graph.services]
        lacks += [each for each in (ends.status, ends.feedback) if each not in graph.topics]
        return f"the robot's own navigation lacks {', '.join(lacks[:4])}: is its node running?"
    return (
        f"nothing is seen of the robot's own navigation {name}: start its node, and a bridge for "
        "Foxglove with include_hidden:=true"
    )


def _type(graph: RosGraph, topic: str) -> str:
    found = graph.topics.get(topic)
    return full_name(found.schema_name) if found is not None else ""
