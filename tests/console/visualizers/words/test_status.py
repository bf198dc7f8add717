"""visualizeStatus and visualizeLabel."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.gcm.autonomy import AUTONOMY_STATE, Phase
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.diagnostics import Diagnostics, DiagnosticStatus
from hub.gcm.diagnostics import Severity as Level
from hub.gcm.navigation import Assistance, MotionState
from hub.gcm.ranges import RANGES
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.joystick_state import JoystickPhase, JoystickState
from rune_tui.model.robot_state import LinkPhase
from rune_tui.model.vehicle import problems_of
from rune_tui.visualizers.parts.severity import Severity
from rune_tui.visualizers.words.status import Status, fitting
from rune_tui.visualizers.words.status_words import status_parts
from tests.console.states import range_readings
from tests.console.visualizers import known
from tests.support.cases import for_each

NAME = "visualizeStatus"


def line(canvas, row: int = 0) -> str:
    return "".join(chr(p or 32) for p in canvas.glyphs[row].tolist()).strip()


@pytest.fixture
def said(made, draw):
    """The status line with these parts of the robot's own state."""

    def say(
        *, age: float = 0.1, held: tuple[str, ...] = (), width: int = 200, ranges=None, **changes
    ) -> str:
        navigation = made.received(made.navigation(**changes), age)
        robot = made.robot(navigation=navigation, ranges=ranges)
        return line(draw(NAME, robot, (width, 2), held=held))

    return say


def test_everything_that_is_known_is_said_in_one_line(made, draw, golden) -> None:
    navigation = made.navigation(
        motion=MotionState.MOVING, linear=0.25, angular=math.radians(-12), battery_fraction=0.5
    )
    robot = made.robot(
        navigation=made.received(navigation),
        camera=made.received(made.camera(pan=math.radians(37))),
        picture=made.received(made.picture(), 0.5),
    )
    canvas = draw(NAME, robot, (130, 2), held=("w", "d"))
    assert line(canvas) == (
        "magellan  linked  MOVING  +0.25 m/s right 12°/s  battery 50% 24.1 V  "
        "nearest 1.80 m ahead  camera 37° left  picture 0.5 s old"
    )
    golden("status", canvas)


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        (MotionState.STANDING, "STANDING"),
        (MotionState.MOVING, "MOVING"),
        (MotionState.SILENCE, "STOPPED: commands fell silent"),
        (MotionState.STOPPED, "STOPPED: a stop was sent"),
        (MotionState.NO_DRIVER, "NO DRIVER: cannot move"),
    ],
)
def test_every_motion_state_has_its_words(said, motion, words) -> None:
    assert words in said(motion=motion)


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        (MotionState.STANDING, "  STOPPING  +0.42 m/s"),
        (MotionState.STOPPED, "STOPPING: a stop was sent"),
        (MotionState.SILENCE, "STOPPING: commands fell silent"),
        (MotionState.NO_DRIVER, "NO DRIVER, and it moves"),
        (MotionState.WAITING, "STOPPING"),
        (MotionState.MOVING, "  MOVING  +0.42 m/s"),
    ],
)
def test_a_robot_that_rolls_on_is_not_said_to_stand(said, motion, words) -> None:
    assert words in said(motion=motion, linear=0.42)


def test_what_is_held_back_is_said(said) -> None:
    assert "HELD BACK 60%" in said(motion=MotionState.MOVING, held_back=0.6)
    assert "HELD BACK" not in said(motion=MotionState.MOVING)


def test_without_a_link_nothing_is_said_to_be_so_now(made) -> None:
    lost = made.robot(
        navigation=made.received(made.navigation(motion=MotionState.MOVING, linear=0.3), 0.4),
        link=made.link(LinkPhase.LOST, since=made.now - 0.4),
    )
    present = ("MOVING", "+0.30", "battery", "nearest")
    texts = [part.text for part in status_parts(lost, ConsoleState(now=made.now))]
    assert not [text for text in texts if text.startswith(present)]
    assert "was MOVING" in texts


def test_what_is_stale_is_said_to_have_been_so(made) -> None:
    robot = made.robot(navigation=made.received(made.navigation(linear=0.42), 30.0))
    parts = status_parts(robot, ConsoleState(now=made.now))
    past = [part for part in parts if part.text.startswith("was ")]
    assert [part.text for part in past] == [
        "was STOPPING",
        "was +0.42 m/s 0°/s",
        "was battery 87% 24.1 V",
        "was nearest 1.80 m ahead",
    ]
    assert {part.severity for part in past} == {Severity.FAINT}


@pytest.mark.parametrize("linear", [0.0, 0.42])
def test_a_driver_that_is_silent_for_long_is_so_now_and_its_motion_is_not_known(
    made, linear: float
) -> None:
    known = made.navigation(motion=MotionState.NO_DRIVER, linear=linear)
    robot = made.robot(navigation=made.received(known, 30.0))
    texts = [part.text for part in status_parts(robot, ConsoleState(now=made.now))]
    assert "NO DRIVER: nobody knows whether it moves" in texts
    assert f"was {linear:+.2f} m/s 0°/s".replace("+0.00", "0.00") in texts
    lost = made.link(phase=LinkPhase.LOST)
    robot = made.robot(navigation=made.received(known, 30.0), link=lost)
    texts = [part.text for part in status_parts(robot, ConsoleState(now=made.now))]
    assert any(text.startswith("was NO DRIVER") for text in texts), "the hub may have a driver"


def test_zoom_is_said(made, draw) -> None:
    robot = made.robot(camera=made.received(made.camera(zoom=0.4)))
    assert "zoom 40%" in line(draw(NAME, robot, (200, 2)))
    assert "zoom" not in line(draw(NAME, made.robot(), (200, 2)))


def test_what_is_about_to_touch_is_an_alarm(made) -> None:
    sonar = np.full(16, np.inf, np.float32)
    sonar[0] = 0.273
    robot = made.robot(ranges=made.received(range_readings(sonar=sonar)))
    severities = {
        part.text: part.severity for part in status_parts(robot, ConsoleState(now=made.now))
    }
    assert severities["CLOSE 0.07 m ahead"] is Severity.ALARM


def test_what_the_robot_does_by_itself_is_said(made, draw) -> None:
    messages = {AUTONOMY_STATE.name: made.received(known.autonomy())}
    moving = made.received(made.navigation(motion=MotionState.GOING, linear=0.3))
    robot = made.robot(navigation=moving, messages=messages)
    assert "EXPLORING 42 %  +0.30 m/s" in line(draw(NAME, robot, (200, 2)))
    silent = made.robot(navigation=moving)
    assert "GOING by itself  " in line(draw(NAME, silent, (200, 2)))


def test_how_it_ended_takes_no_room_from_what_keeps_it_safe(made) -> None:
    """Who has control, the battery and the nearest thing stay on 80 columns."""
    why = "explored: nothing is left that the robot could reach from where it is"
    done = known.autonomy(phase=Phase.DONE, why=why, ended_s=1.0)
    messages = {
        AUTONOMY_STATE.name: made.received(done),
        CONTROL_STATE.name: made.received(ControlState()),
    }
    robot = made.robot(messages=messages)
    limits = {"magellan": 0.1}
    state = ConsoleState(now=made.now, robots={"magellan": robot}, speed_limits=limits)
    words = [part.text for part in fitting(status_parts(robot, state), 80)]
    for least in ("nobody", "battery", "nearest 1.80 m ahead", "limit 10%"):
        assert any(each.startswith(least) for each in words), words
    assert f"EXPLORING 42 % DONE: {why}" in [part.text for part in status_parts(robot, state)]


def test_the_speed_limit_of_hands_is_not_said_of_what_it_does_by_itself(made, draw) -> None:
    state = ConsoleState(now=made.now, speed_limits={"magellan": 0.1})
    assert "limit 10%" in line(draw(NAME, made.robot(), (200, 2), state=state))
    going = made.received(made.navigation(motion=MotionState.GOING))
    exploring = {AUTONOMY_STATE.name: made.received(known.autonomy())}
    for robot in (made.robot(navigation=going), made.robot(messages=exploring)):
        assert "limit" not in line(draw(NAME, robot, (200, 2), state=state))


@pytest.mark.parametrize(
    ("motion", "assistance", "words"),
    [
        (MotionState.MOVING, Assistance.ON, "CLOSE"),
        (MotionState.GOING, Assistance.OFF, "CLOSE"),
        (MotionState.GOING, Assistance.ON, "NEAR"),
    ],
)
def test_what_it_passes_closely_by_itself_is_a_caution(made, motion, assistance, words) -> None:
    sonar = np.full(16, np.inf, np.float32)
    sonar[0] = 0.273
    navigation = made.navigation(motion=motion, assistance=assistance)
    ranges = made.received(range_readings(sonar=sonar))
    robot = made.robot(navigation=made.received(navigation), ranges=ranges)
    severities = {
        part.text: part.severity for part in status_parts(robot, ConsoleState(now=made.now))
    }
    severity = Severity.ALARM if words == "CLOSE" else Severity.WARNING
    assert severities[f"{words} 0.07 m ahead"] is severity


@pytest.mark.parametrize(
    ("motion", "severity"),
    [
        (MotionState.STOPPED, Severity.PLAIN),
        (MotionState.SILENCE, Severity.ALARM),
        (MotionState.NO_DRIVER, Severity.ALARM),
    ],
)
def test_a_stop_that_somebody_wanted_is_no_alarm(made, motion, severity) -> None:
    robot = made.robot(navigation=made.received(made.navigation(motion=motion)))
    found = status_parts(robot, ConsoleState(now=made.now))
    assert [part.severity for part in found if part.text.startswith(("STOPPED", "NO DRIVER"))] == [
        severity
    ]


def test_what_other_panes_say_is_left_to_them(made, draw) -> None:
    navigation = made.navigation(battery_fraction=0.15, linear=0.42)
    robot = made.robot(navigation=made.received(navigation))
    low = "BATTERY LOW 15% 24.1 V"
    assert low in line(draw(NAME, robot, (200, 2)))
    text = line(draw(NAME, robot, (200, 2), beside="alarms and gauges"))
    assert low not in text
    assert "m/s" not in text
    assert "STOPPING" in text
    assert low in line(draw(NAME, robot, (200, 2), beside="gauges"))


@pytest.mark.parametrize("over", [{"full": "camera"}, {"help": True}, {"log": True}])
def test_while_no_gauges_are_in_sight_the_line_says_what_they_say(made, draw, over) -> None:
    robot = made.robot(navigation=made.received(made.navigation(linear=0.42)))
    state = ConsoleState(now=made.now, **over)
    text = line(draw(NAME, robot, (200, 2), state=state, beside="alarms and gauges"))
    assert "m/s" in text
    assert "battery" in text


def test_no_speed_has_no_sign(said) -> None:
    assert "  0.00 m/s 0°/s  " in said(linear=-0.001, angular=0.001)


@pytest.mark.parametrize(
    ("fraction", "voltage", "words"),
    [(0.87, math.nan, "battery 87%  "), (math.nan, 24.1, "battery 24.1 V  "), (0.1, 20.0, "LOW")],
)
def test_of_the_battery_only_what_is_known_is_said(said, fraction, voltage, words) -> None:
    assert words in said(battery_fraction=fraction, battery_voltage=voltage)


def test_an_unknown_battery_is_not_mentioned(said) -> None:
    assert "battery" not in said(battery_fraction=math.nan, battery_voltage=math.nan)


@pytest.mark.parametrize(
    ("sensor", "side"),
    [
        (0, "ahead"),
        (1, "ahead"),
        (3, "left"),
        (4, "left"),
        (8, "behind"),
        (12, "right"),
        (15, "ahead"),
    ],
)
def test_the_nearest_obstacle_is_told_from_the_rim_with_its_side(made, said, sensor, side) -> None:
    ranges = np.full(16, np.inf, np.float32)
    ranges[sensor] = 0.503
    for readings in (range_readings(sonar=ranges), range_readings(infrared=ranges)):
        assert f"NEAR 0.30 m {side}" in said(ranges=made.received(readings))


def test_nothing_seen_is_not_called_near(made, said) -> None:
    nothing = np.full(16, np.inf, np.float32)
    nothing[3] = np.nan
    assert "m ahead" not in said(ranges=made.received(range_readings(sonar=nothing)))


def test_old_ranges_are_an_alarm_of_their_own(made, said) -> None:
    def at(age: float) -> str:
        return said(ranges=made.received(range_readings(), age))

    assert "RANGES" not in at(0.9)
    assert "RANGES 1.5 s OLD  nearest 1.80 m ahead" in at(1.5)
    assert "RANGES 4.0 s OLD  was nearest 1.80 m ahead" in at(4.0)
    silent = said(age=1.5, ranges=made.received(range_readings(), 1.5))
    assert "RANGES" not in silent  # the old state says it already


def test_missing_ranges_are_said(made, draw) -> None:
    robot = made.robot()
    known = {name: each for name, each in robot.messages.items() if name != RANGES.name}
    text = line(draw(NAME, robot.with_(messages=known), (200, 2)))
    assert "no ranges from magellan yet" in text
    assert "nearest" not in text


def test_old_state_is_called_old(said) -> None:
    assert "OLD" not in said(age=0.9)
    assert "STATE 1.5 s OLD" in said(age=1.5)


def test_a_camera_whose_pictures_stay_the_same_is_mentioned_and_is_no_alarm(made, draw) -> None:
    text = "camera front: the same picture for 12 s"
    status = DiagnosticStatus(level=Level.OK, name="camera front", message=text)
    found = made.received(Diagnostics(status=(status,)))
    robot = made.robot(picture=made.received(made.picture()), diagnostics={7: found})
    assert text in line(draw(NAME, robot, (200, 2)))
    assert [*problems_of(robot)] == []


def test_a_small_pan_and_a_fresh_picture_are_not_mentioned(made, draw) -> None:
    robot = made.robot(camera=made.received(made.camera(pan=math.radians(-4.9))))
    text = line(draw(NAME, robot, (200, 2)))
    assert "camera" not in text
    assert "picture" not in text
    robot = made.robot(camera=made.received(made.camera(pan=math.radians(-6))))
    assert "camera 6° right" in line(draw(NAME, robot, (200, 2)))


@pytest.mark.parametrize(
    ("phase", "words"),
    [(LinkPhase.CONNECTING, "connecting 3 s"), (LinkPhase.LOST, "LINK LOST 3 s")],
)
def test_a_link_that_is_not_there_is_named(made, draw, phase, words) -> None:
    robot = made.robot(link=made.link(phase), navigation=None)
    text = line(draw(NAME, robot, (200, 2)))
    assert words in text
    assert "no robot state yet" in text


@pytest.mark.parametrize("phase", list(LinkPhase))
def test_an_observer_is_called_one_on_any_link_even_where_room_is_short(made, draw, phase) -> None:
    robot = made.robot(link=made.link(phase, may_command=False))
    assert "OBSERVER: this key may watch and stop, not drive" in line(draw(NAME, robot, (80, 2)))
    assert "OBSERVER" not in line(draw(NAME, made.robot(link=made.link(phase)), (200, 2)))


def test_where_room_is_short_whole_parts_go_and_the_gravest_stays(made, draw) -> None:
    robot = made.robot(link=made.link(LinkPhase.LOST))
    whole = line(draw(NAME, robot, (200, 2)))
    for width in range(1, 90):
        shown = line(draw(NAME, robot, (width, 2)))
        text = shown.removesuffix("…")
        assert shown, width
        assert "LINK LOST 3 s".startswith(text) or "LINK LOST 3 s" in text, width
        assert all(part in whole for part in text.split("  ")), width


def least(made, columns: int, names: tuple[str, ...], **changes) -> list[str]:
    """What is said last, with so much room beside all that is said before."""
    robot = made.robot(navigation=made.received(made.navigation(), 0.1))
    before = status_parts(robot, ConsoleState(now=made.now))[:-1]
    pads = {name: JoystickState(name=name) for name in names}
    state = ConsoleState(now=made.now, joysticks=pads, hold_s=0.15, **changes)
    room = sum(len(part.text) + 2 for part in before) + columns
    return [part.text for part in fitting(status_parts(robot, state), room)[len(before) :]]


@for_each(
    ("columns", "said"),
    [
        (41, ["pad not plugged in", "release: timed 0.15 s"]),
        (40, ["pad not plugged in", "release: timed"]),
        (34, ["pad not plugged in", "release: timed"]),
        (33, ["no pad", "release: timed"]),
        (22, ["no pad", "release: timed"]),
        (21, ["no pad"]),
        (5, []),
    ],
)
def test_that_no_pad_is_there_and_when_keys_go_up_are_both_said_in_fewer_words_if_need_be(
    made, columns, said
) -> None:
    assert least(made, columns, ("pad",)) == said


def test_of_several_pads_that_are_not_there_fewer_words_tell_no_number(made) -> None:
    pads = ("left", "right")
    assert least(made, 99, pads, releases_reported=True)[0] == "2 joysticks not plugged in"
    assert least(made, 28, pads, releases_reported=True) == ["no joysticks", "release: exact"]


def test_the_token_changes_with_the_words_only(made) -> None:
    shown, state = Status(), ConsoleState(now=made.now)

    def token(**changes):
        return shown.source(made.robot(navigation=made.received(made.navigation(**changes))), state)

    assert token(linear=0.25) == token(linear=0.251, x=3.0)
    assert token(linear=0.25) != token(linear=0.26)
    robot = made.robot()
    held = ConsoleState(now=made.now, held=("w",))
    assert shown.source(robot, state) != shown.source(robot, held)


def test_keys_that_must_go_up_first_are_named(made) -> None:
    state = ConsoleState(now=made.now, must_release=("w", "d"))
    parts = {part.text: part for part in status_parts(made.robot(), state)}
    assert parts["LET GO OF w d FOR 1 s FIRST"].severity is Severity.WARNING
    exact = ConsoleState(now=made.now, must_release=("w", "d"), releases_reported=True)
    assert "LET GO OF w d FIRST" in {part.text for part in status_parts(made.robot(), exact)}
    hasty = ConsoleState(now=made.now, must_release=("w",), tap_first=True)
    assert "LET GO OF w, TAP, THEN HOLD" in {p.text for p in status_parts(made.robot(), hasty)}


def test_what_a_pad_lacks_takes_no_room_from_what_matters_more(made) -> None:
    lacking = JoystickState(
        name="pad", phase=JoystickPhase.CONNECTED, why="it has no b, rightx, righty, dpad, x, y"
    )
    state = ConsoleState(now=made.now, joysticks={"pad": lacking}, recording="run1.mcap")
    words = [part.text for part in fitting(status_parts(made.robot(), state), 80)]
    assert "REC" in words
    assert not [each for each in words if "rightx" in each]
    wide = [part.text for part in fitting(status_parts(made.robot(), state), 400)]
    assert "pad it has no b, rightx, righty, dpad, x, y" in wide


def test_a_label_says_its_text_wrapped_and_lets_the_rest_be_seen(made, draw, golden) -> None:
    canvas = draw("visualizeLabel", made.robot(), (10, 6), text="Magellan Pro of the lab")
    assert [line(canvas, row) for row in range(3)] == ["Magellan", "Pro of the", "lab"]
    assert not canvas.pixels.any()
    golden("label", canvas)


def test_of_a_list_of_keys_whole_pieces_go_and_how_to_stop_stays(made, draw) -> None:
    text = "Space STOP · WASD drive · IJKL look · F1 help · Q quit"
    for width in range(10, 70):
        shown = line(draw("visualizeLabel", made.robot(), (width, 2), text=text))
        assert shown.startswith("Space STOP")
        assert shown.endswith("F1 help · Q quit" if width >= 29 else "Q quit" if width > 18 else "")
        assert set(shown.split(" · ")) <= set(text.split(" · "))
    assert line(draw("visualizeLabel", made.robot(), (70, 2), text=text)) == text


def test_who_only_watches_is_not_said_to_wait_for_a_command(made, draw) -> None:
    waiting = made.received(made.navigation(motion=MotionState.WAITING))
    watched = made.robot(navigation=waiting, link=made.link(may_command=False))
    assert "STANDING" in line(draw(NAME, watched, (200, 2)))
    driven = made.robot(navigation=waiting)
    assert "READY" in line(draw(NAME, driven, (200, 2)))
