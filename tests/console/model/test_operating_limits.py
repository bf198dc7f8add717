"""What a condition of a study refuses: nothing that drives a robot by itself gets past it."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.autonomy import AUTONOMY_COMMAND, AutonomyCommand, Behaviour
from hub.gcm.body import HoldKind
from hub.gcm.geometry import Twist, TwistStamped, Vector3
from hub.gcm.navigation import (
    ASSISTANCE_COMMAND,
    GOAL_COMMAND,
    STOP,
    TURN_COMMAND,
    VELOCITY_COMMAND,
    Assistance,
    AssistanceCommand,
    GoalCommand,
    Point,
    Stop,
    TurnCommand,
)
from hub.gcm.vehicle import VEHICLE_COMMAND, VehicleCommand, VehicleOrder
from hub.ipc.definition import MessageDefinition
from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.robots.mavlink.profiles.table import PROFILES
from rune_tui.dispatch import Dispatch
from rune_tui.layout.actions import actions_of
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect
from rune_tui.model.limited_effects import within
from rune_tui.model.operating_limits import (
    ASSISTANCE,
    AUTONOMY,
    NO_LIMITS,
    AutonomyLevel,
    OperatingLimits,
)
from rune_tui.model.robot_state import LinkPhase, LinkState
from rune_tui.startup.opening import open_layout
from tests.console.states import robot_of

LAYOUTS = sorted((Path(__file__).parents[3] / "layouts").glob("*.xml"))
TELEOPERATION, GOALS, ALL = (OperatingLimits(autonomy=level) for level in AutonomyLevel)
POINT = Point(x=1.0, y=2.0)
OFF = AssistanceCommand(assistance=Assistance.OFF)
ON = AssistanceCommand(assistance=Assistance.ON)


def behave(behaviour: Behaviour) -> tuple[MessageDefinition[Any], AutonomyCommand]:
    return AUTONOMY_COMMAND, AutonomyCommand(behaviour=behaviour)


def hold(value: float) -> tuple[MessageDefinition[Any], VehicleCommand]:
    order = VehicleCommand(order=VehicleOrder.HOLD, hold=HoldKind.DEPTH, value=value)
    return VEHICLE_COMMAND, order


def mode(name: str) -> tuple[MessageDefinition[Any], VehicleCommand]:
    return VEHICLE_COMMAND, VehicleCommand(order=VehicleOrder.MODE, name=name)


ENDS = [
    (STOP, Stop(reason="now")),
    (VELOCITY_COMMAND, TwistStamped.of(Twist(linear=Vector3(x=1.0)))),
    (GOAL_COMMAND, GoalCommand()),
    behave(Behaviour.HOLD),
    hold(math.nan),
    *(mode(name) for name in ("guided", "hold", "position hold", "depth hold", "manual")),
]
NEED_GOALS = [
    (GOAL_COMMAND, GoalCommand(points=(POINT,))),
    (TURN_COMMAND, TurnCommand(angle=1.0)),
    behave(Behaviour.GO),
    behave(Behaviour.FOLLOW),
    behave(Behaviour.RETURN),
    hold(-2.0),
    *(mode(name) for name in ("auto", "rtl", "circle", "surface", "", "Guided", "mode 99")),
]
NEED_EXPLORATION = [behave(Behaviour.EXPLORE), behave(Behaviour.WANDER)]


def test_each_level_refuses_what_is_above_it() -> None:
    for message in ENDS:
        assert not TELEOPERATION.refusal(*message), message
    for message in NEED_GOALS:
        assert TELEOPERATION.refusal(*message), message
        assert not GOALS.refusal(*message), message
    for message in NEED_EXPLORATION:
        assert TELEOPERATION.refusal(*message), message
        assert GOALS.refusal(*message), message
    for message in (*ENDS, *NEED_GOALS, *NEED_EXPLORATION):
        assert not ALL.refusal(*message), message
    known = {*Behaviour}
    tried = {
        value.behaviour
        for _, value in NEED_GOALS + NEED_EXPLORATION + ENDS
        if isinstance(value, AutonomyCommand)
    }
    assert tried == known


@pytest.mark.parametrize("profile", [each for _, each in PROFILES], ids=lambda each: each.name)
def test_an_autopilot_in_teleoperation_follows_or_holds_only(profile: VehicleProfile) -> None:
    kept = {*profile.drives} | ({profile.holds} - {None})
    for number in kept:
        assert not TELEOPERATION.refusal(*mode(profile.modes[number]))
    others = {name for name in profile.modes.values() if TELEOPERATION.refusal(*mode(name))}
    alone = {
        "auto",
        "rtl",
        "smart rtl",
        "circle",
        "dock",
        "follow",
        "surface",
        "land",
        "mission",
        "return",
    }
    assert alone & {*profile.modes.values()} <= others


def test_a_strange_value_of_a_message_that_drives_is_refused() -> None:
    for definition in (GOAL_COMMAND, AUTONOMY_COMMAND, TURN_COMMAND):
        assert TELEOPERATION.refusal(definition, {"behaviour": 0, "points": ()})


def test_assistance_that_is_kept_cannot_be_switched_and_may_be_repeated() -> None:
    for word, allowed, refused in (("on", ON, OFF), ("off", OFF, ON)):
        limits = OperatingLimits.read(f"exploration/{word}")
        assert limits is not None
        assert limits.kept == allowed
        assert not limits.refusal(ASSISTANCE_COMMAND, allowed)
        assert limits.refusal(ASSISTANCE_COMMAND, refused) == f"assistance stays {word}"
    assert NO_LIMITS.kept is None
    assert not NO_LIMITS.refusal(ASSISTANCE_COMMAND, OFF)


def test_limits_are_read_as_they_are_written() -> None:
    for autonomy in AUTONOMY:
        for assistance in ASSISTANCE:
            text = f"{autonomy}/{assistance}"
            assert str(OperatingLimits.read(text)) == text
    for wrong in ("", "goals", "goals/", "goal/on", "/on", "goals/on/off", "GOALS/on"):
        assert OperatingLimits.read(wrong) is None


def state_with(limits: OperatingLimits, *names: str) -> ConsoleState:
    link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
    robots = {name: robot_of(name=name, link=link) for name in names}
    return ConsoleState(now=5.0, robots=robots, chosen=names[0], limits=limits)


def test_a_notice_takes_the_place_of_a_goal_and_of_what_confirms_it() -> None:
    state = state_with(TELEOPERATION, "a", "b")
    goal = SendEffect(robot="a", definition=GOAL_COMMAND, value=GoalCommand(points=(POINT,)))
    sent = Notify.now(state, "sent to 1.0, 2.0 m", robot="a")
    alarm = Notify.now(state, "a bump", robot="a", alarm=True)
    other = Notify.now(state, "a mark is kept", robot="b")
    stop = SendEffect(robot="a", definition=STOP, value=Stop(reason="now"))
    notice, *rest = within([goal, sent, alarm, other, stop], state)
    assert isinstance(notice, Notify)
    assert notice.notice.text == "not in this condition: robots do not drive by themselves"
    assert (notice.notice.robot, notice.notice.alarm) == ("a", True)
    assert rest == [alarm, other, stop]


POINTS = st.lists(st.builds(Point, x=st.floats(-9, 9), y=st.floats(-9, 9)), max_size=3).map(tuple)
MESSAGES = st.one_of(
    st.tuples(st.just(GOAL_COMMAND), st.builds(GoalCommand, points=POINTS)),
    st.tuples(st.just(TURN_COMMAND), st.builds(TurnCommand, angle=st.floats(-9, 9))),
    st.tuples(
        st.just(AUTONOMY_COMMAND),
        st.builds(AutonomyCommand, behaviour=st.sampled_from(Behaviour), points=POINTS),
    ),
    st.sampled_from(ENDS),
)


@given(st.lists(st.tuples(st.sampled_from("ab"), MESSAGES)))
def test_in_teleoperation_no_goal_leaves_and_all_else_does(
    meant: list[tuple[str, tuple[MessageDefinition[Any], Any]]],
) -> None:
    state = state_with(TELEOPERATION, "a", "b")
    effects: list[Effect] = [
        SendEffect(robot=robot, definition=definition, value=value)
        for robot, (definition, value) in meant
    ]
    left = within(effects, state)
    assert all(map(ends_or_drives, (each for each in left if isinstance(each, SendEffect))))
    assert [each for each in left if isinstance(each, SendEffect)] == [
        each for each in effects if isinstance(each, SendEffect) and ends_or_drives(each)
    ]
    assert len(left) == len(effects)
    assert within(left, state) == left


def ends_or_drives(effect: SendEffect) -> bool:
    """By the meaning of messages at the robot: whether it begins no task of its own."""
    value = effect.value
    if isinstance(value, GoalCommand):
        return not value.points
    if isinstance(value, AutonomyCommand):
        return value.behaviour is Behaviour.HOLD
    return not isinstance(value, TurnCommand)


@pytest.mark.parametrize("path", LAYOUTS, ids=lambda path: path.stem)
def test_no_action_of_a_shipped_layout_begins_a_task_or_takes_control_for_it(path: Path) -> None:
    layout = open_layout(path)
    state = state_with(TELEOPERATION, *(robot.name for robot in layout.robots))
    free = dataclasses.replace(state, limits=NO_LIMITS)
    refused = 0
    for action in actions_of(layout):
        found = Dispatch(layout).act(action, state)
        assert all(ends_or_drives(each) for each in found if isinstance(each, SendEffect))
        usual = Dispatch(layout).act(action, free)
        if not all(ends_or_drives(each) for each in usual if isinstance(each, SendEffect)):
            refused += 1
            assert [type(each) for each in found] == [Notify]
    starts = {"demo", "search", "land-sea-air"}
    assert (refused > 0) == (path.stem in starts)
