"""The doctor on the robot of a robot file with ROS."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from typing import Final

from hub.errors import HubError, RosSilentError
from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.plain_text import plain
from hub.robots.body_tables import ROBOTS_OWN
from hub.robots.description import RobotDescription
from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.findings import RosFindings
from hub.robots.ros.asking.proposal import RosProposal, open_way_of, refused_command
from hub.robots.ros.asking.stopping import stopping
from hub.robots.ros.asking.survey import look_at
from hub.robots.ros.goals.goal_actions import (
    action_of,
    actions_of,
    driving_nodes,
    missing_action,
)
from hub.robots.ros.line import RosTopic
from hub.robots.ros.line_loop import LineLoop
from hub.robots.ros.odometry import odometry_fault
from hub.robots.ros.own_nodes import foreign
from hub.robots.ros_table import ROS_KIND, CommandType

_LISTENING_S: Final = 3.0
_OLD_S: Final = 0.2
_RARE_HZ: Final = 5.0


def ros(robot: RobotDescription) -> list[Finding]:
    """Whether the robot is there, what stops it, and whether its parts are there."""
    if robot.kind != ROS_KIND:
        return [ok("not needed: the robot has no ROS")]
    from hub.robots.ros.opening import line_to

    try:
        address = ros_address(robot.ros.address)
        with contextlib.closing(LineLoop(line_to(address, robot.ros.certificates))) as loop:
            found = look_at(loop, address, _LISTENING_S, also=[*_topics(robot)])
    except RosSilentError as fault:
        return [problem(str(fault), "start its bridge or router, or correct [ros]")]
    except HubError as fault:
        return [problem(str(fault), "correct [ros] in the robot file")]
    return [
        ok(f"{address.text}: a {RosProposal(found).title}"),
        *_driving(found, robot),
        *_odometry(found, robot),
        *_navigation(found, robot),
        *_parts(found, robot),
        *_warnings(found),
    ]


def _topics(robot: RobotDescription) -> Iterator[str]:
    """The topics that the robot file names, except that of velocities."""
    table = robot.ros
    named = [table.odom, table.battery, table.imu, table.joints, table.pressure, table.map]
    named += [each.topic for each in robot.ranges]
    named += [each.topic for each in robot.cameras if each.source == ROBOTS_OWN]
    yield from filter(None, dict.fromkeys(named))


def _driving(found: RosFindings, robot: RobotDescription) -> Iterator[Finding]:
    """Whether velocities arrive, and what stops the robot without them."""
    name, hold = robot.ros.cmd_vel, robot.ros.hold
    command = found.graph.topics.get(name)
    typed = robot.ros.cmd_vel_type is not CommandType.AUTO or found.graph.version == 1
    if command is None and not found.graph.whole and typed:
        command = RosTopic(name=name)
        advice = "the bridge does not say which topics it takes: try whether the robot drives"
        yield warning(f"it is not known whether a node subscribes to {name}", advice)
    if command is None:
        yield problem(f"the robot has no topic {name}", "correct [ros], key 'cmd_vel'")
        return
    yield from _taking(found, command)
    if found.graph.whole and not foreign(command.subscribers):
        advice = "start the node that drives, or correct [ros], key 'cmd_vel'"
        yield warning(f"no node subscribes to {name}: the robot will not move", advice)
    own = driving_nodes(found.graph, robot.ros.navigation)
    if more := [each for each in foreign(command.publishers) if each not in own]:
        text = f"{plain(', '.join(more[:4]))[:300]} also publishes {name}: the newest counts"
        yield warning(text, "end it, or put twist_mux between")
    stop = stopping(found, command)
    remedy = f"set {stop.source} to 0.5" if stop.source else "give the robot's base a time-out"
    if stop.safe and hold:
        advice = "remove 'hold' from [ros]: with it no other node of the robot can drive"
        yield warning(f"{stop.words}, so it needs no 'hold'", advice)
    elif stop.safe:
        yield ok(stop.words)
    elif math.isinf(stop.seconds) and not hold:
        yield problem(stop.words, f"{remedy}, or write hold = true under [ros]")
    elif math.isinf(stop.seconds):
        text = f"{stop.words}; 'hold' repeats the zero only while this hub and the line live"
        yield warning(text, remedy)
    else:
        yield warning(stop.words, remedy)


def _taking(found: RosFindings, command: RosTopic) -> Iterator[Finding]:
    """Whether the bridge takes velocities."""
    if not found.takes:
        advice = (
            f"give it the capability clientPublish, and {command.name} in client_topic_whitelist"
        )
        yield problem("the bridge takes no messages, so the robot cannot be driven", advice)
    if refused := refused_command(found, command):
        text, _, advice = refused.partition(": ")
        yield problem(f"{text}, so the robot cannot be driven", advice)


def _odometry(found: RosFindings, robot: RobotDescription) -> Iterator[Finding]:
    name = robot.ros.odom
    if not name:
        return
    heard = found.of(name)
    if heard.value is None:
        why = heard.fault or "nothing came on it"
        advice = "correct [ros], key 'odom'; without it the frames of 'tf' count"
        yield warning(f"{name}: {why}", advice)
    elif fault := odometry_fault(heard.value):
        advice = "correct the node that publishes it: Rune does not drive without a place"
        yield problem(f"{name}: {fault}", advice)
    elif heard.age > _OLD_S:
        text = f"{name} comes {heard.age:.1f} s late"
        yield problem(text, "run the hub on the robot's computer, or find what fills the network")
    elif heard.rate_hz < _RARE_HZ:
        yield warning(f"{name} comes {heard.rate_hz:.1f} times a second", "have it come 20 times")
    else:
        late = "" if math.isnan(heard.age) else f", {1000.0 * heard.age:.0f} ms old"
        yield ok(f"{name} comes {heard.rate_hz:.0f} times a second{late}")


def _navigation(found: RosFindings, robot: RobotDescription) -> Iterator[Finding]:
    """Whether the robot's own navigation takes goals."""
    name, graph = robot.ros.navigation, found.graph
    if name and action_of(graph, name) is not None:
        yield ok(f"its own navigation {name} takes goals")
    elif name:
        text, _, advice = missing_action(graph, name).partition(": ")
        yield warning(f"{text}, so goals go to Rune's own", advice or "correct [ros]")
    elif others := [each.name for each in actions_of(graph) if found.counts(each.name)]:
        text = f"it has navigation of its own, {plain(', '.join(others[:4]))[:200]}"
        yield ok(f"{text}; without the key 'navigation' in [ros] Rune's own drives to goals")


def _parts(found: RosFindings, robot: RobotDescription) -> Iterator[Finding]:
    """Topics of the robot file from which nothing comes."""
    for name in _topics(robot):
        heard = found.of(name)
        if name == robot.ros.odom or (heard.messages and not heard.fault):
            continue
        missing = "the robot has no such topic" if name not in found.graph.topics else ""
        why = missing or heard.fault or f"nothing came in {_LISTENING_S:g} s"
        yield warning(f"{name}: {why}", "start the node that publishes it, or correct its name")


def _warnings(found: RosFindings) -> Iterator[Finding]:
    """What the bridge says, and who else may drive."""
    if open_way := open_way_of(found):
        text, _, remedy = open_way.partition(": ")
        yield warning(text, remedy)
    for note in found.notes:
        yield warning(plain(note)[:300], "look at the bridge's own log")
