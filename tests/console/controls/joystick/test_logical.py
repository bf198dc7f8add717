from __future__ import annotations

import itertools
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.events import ControlEvent
from rune_tui.controls.joystick.calibration import Calibration
from rune_tui.controls.joystick.logical import LogicalJoystick
from rune_tui.layout.spec import ControlKind, ControlSpec, JoystickSpec
from tests.console.controls.joystick.pads import (
    ALL,
    BALL,
    HAT,
    LEFT_X,
    LEFT_Y,
    PAD,
    REST,
    TRIGGER,
    A,
    control,
    joystick,
    physical,
    told,
)
from tests.support.cases import for_each

_times = itertools.count(1.0, 0.01)


def resting(spec: JoystickSpec = ALL) -> LogicalJoystick:
    """A joystick whose device has just appeared, untouched."""
    pad = LogicalJoystick(spec)
    assert pad.connect(PAD, {}) == ()
    assert pad.feed(REST, 0.0) == ()
    return pad


def moved(pad: LogicalJoystick, *values: tuple[int, int | None]) -> list[object]:
    return list(told(pad.feed(values, next(_times))))


def test_an_axis_leaves_neutral_moves_and_comes_back() -> None:
    pad = resting()
    assert moved(pad, (LEFT_X, 192)) == [
        ("leftx", True, False, pytest.approx(0.359, abs=0.01)),
        ("leftx pressed", True, False, 1.0),
    ]
    assert moved(pad, (LEFT_X, 255)) == [
        ("leftx", True, True, 1.0),
    ]
    assert pad.values["leftx"] == 1.0
    assert moved(pad, (LEFT_X, 128)) == [
        ("leftx", False, False, 0.0),
        ("leftx pressed", False, False, 0.0),
    ]
    assert pad.values["leftx"] == 0.0


def test_up_is_positive_on_a_device_whose_numbers_grow_down() -> None:
    (event, _) = resting().feed([(LEFT_Y, 0)], 1.0)
    assert event.value == 1.0
    inverted = resting(joystick(control("lefty", invert=True)))
    (event, _) = inverted.feed([(LEFT_Y, 0)], 1.0)
    assert event.value == -1.0


def test_the_same_number_again_or_noise_within_the_dead_zone_says_nothing() -> None:
    pad = resting()
    assert moved(pad, (LEFT_X, 133)) == []
    moved(pad, (LEFT_X, 200))
    assert moved(pad, (LEFT_X, 200)) == []


def test_a_trigger_goes_from_0_to_1_and_is_a_button_early() -> None:
    pad = resting()
    names = [name for name, pressed, *_ in moved(pad, (TRIGGER, 40)) if pressed]
    assert names == ["righttrigger", "righttrigger pressed"]
    (event,) = pad.feed([(TRIGGER, 255)], 9.0)
    assert event.value == 1.0
    assert [(name, pressed) for name, pressed, *_ in moved(pad, (TRIGGER, 0))] == [
        ("righttrigger", False),
        ("righttrigger pressed", False),
    ]


def test_an_axis_as_a_button_does_not_flutter_about_its_threshold() -> None:
    pad = resting()

    def pressed(raw: int) -> list[bool]:
        return [down for name, down, *_ in moved(pad, (LEFT_X, raw)) if "pressed" in name]

    assert pressed(195) == [True]
    assert pressed(185) == []
    assert pressed(195) == []
    assert pressed(170) == [False]
    assert pressed(185) == []


def test_a_diagonal_of_a_hat_is_two_directions() -> None:
    pad = resting()
    assert moved(pad, (HAT, 1)) == [("dpad up", True, False, 1.0), ("dpad right", True, False, 1.0)]
    assert moved(pad, (HAT, 2)) == [("dpad up", False, False, 0.0)]
    assert moved(pad, (HAT, None)) == [("dpad right", False, False, 0.0)]


def test_a_ball_tells_its_counts_and_is_never_released() -> None:
    pad = resting()
    assert moved(pad, (BALL, 5)) == [("wheel", True, False, 5.0)]
    assert moved(pad, (BALL, 0)) == []
    assert pad.release_all() == ()


def test_a_cross_of_buttons_is_a_hat_and_a_hat_is_a_cross_of_buttons() -> None:
    cross = LogicalJoystick(joystick(control("dpleft")))
    assert cross.connect(PAD, {}) == ()
    assert told(cross.feed([(HAT, 6)], 1.0)) == [("dpleft", True, False, 1.0)]
    hat = LogicalJoystick(joystick(control("dpad")))
    buttons = [
        physical(ControlKind.BUTTON, f"button {number}", role, high=1)
        for number, role in enumerate(("dpup", "dpright", "dpdown", "dpleft"), 1)
    ]
    assert hat.connect(buttons, {}) == ()
    assert told(hat.feed([(2, 1)], 1.0)) == [("dpad down", True, False, 1.0)]


def test_what_the_device_does_not_have_is_named() -> None:
    pad = LogicalJoystick(joystick(control("leftx"), control("rightx"), control("b")))
    assert pad.connect(PAD, {}) == ("rightx", "b")


@for_each(
    "spec",
    [
        ControlSpec(name="fire", kind=ControlKind.BUTTON, usage="button 1"),
        ControlSpec(name="fire", kind=ControlKind.BUTTON, index=0),
        ControlSpec(name="fire", kind=ControlKind.BUTTON, role="button1"),
        ControlSpec(name="fire", kind=ControlKind.BUTTON, role="a"),
    ],
)
def test_a_control_is_meant_by_usage_index_number_or_role(spec: ControlSpec) -> None:
    pad = LogicalJoystick(joystick(spec))
    assert pad.connect(PAD, {}) == ()
    assert told(pad.feed([(A, 1)], 1.0)) == [("fire", True, False, 1.0)]


def test_what_is_deflected_when_the_device_appears_counts_only_after_neutral() -> None:
    pad = LogicalJoystick(ALL)
    pad.connect(PAD, {})
    assert moved(pad, (LEFT_X, 255), (TRIGGER, 255)) == []
    assert moved(pad, (LEFT_X, 250)) == []
    assert pad.values["leftx"] > 0.9, "it is shown all the same"
    assert moved(pad, (LEFT_X, 128)) == []
    assert moved(pad, (LEFT_X, 255))[0] == ("leftx", True, False, 1.0)
    assert moved(pad, (TRIGGER, 200)) == []


def test_a_button_counts_from_the_first_press_even_if_nothing_was_heard_before() -> None:
    pad = LogicalJoystick(ALL)
    pad.connect(PAD, {})
    assert moved(pad, (A, 1)) == [("a", True, False, 1.0)]


def test_a_button_that_was_held_as_the_device_was_lost_counts_after_it_went_up() -> None:
    pad = resting()
    moved(pad, (A, 1))
    assert told(pad.lost()) == [("a", False, False, 0.0)]
    pad.connect(PAD, {})
    assert moved(pad, (A, 1)) == []
    assert moved(pad, (A, 0)) == []
    assert moved(pad, (A, 1)) == [("a", True, False, 1.0)]


def test_a_worn_stick_rests_where_it_was_found() -> None:
    pad = LogicalJoystick(ALL)
    pad.connect(PAD, {})
    pad.feed([(LEFT_X, 150)], 0.0)
    assert moved(pad, (LEFT_X, 155)) == []
    assert moved(pad, (LEFT_X, 128)) == []
    assert moved(pad, (LEFT_X, 255))[0][:2] == ("leftx", True)


def test_a_rest_that_was_a_hand_is_put_right_once_the_stick_is_left_alone() -> None:
    pad = LogicalJoystick(ALL)
    pad.connect(PAD, {})
    pad.feed([(LEFT_X, 155)], 0.0)
    assert pad.feed([(LEFT_X, 128)], 0.1) == (), "letting go must not drive the other way"
    pad.feed([(LEFT_X, 129)], 5.0)
    assert [event.pressed for event in pad.feed([(LEFT_X, 155)], 5.1)] == [True]


def test_a_stick_that_never_reaches_its_nominal_end_reaches_1_all_the_same() -> None:
    pad = resting()
    for _ in range(4):
        moved(pad, (LEFT_X, 220))
        moved(pad, (LEFT_X, 128))
    assert moved(pad, (LEFT_X, 219))[0] == ("leftx", True, False, 1.0)


def test_a_calibrated_axis_has_its_own_centre_and_ends() -> None:
    pad = LogicalJoystick(ALL)
    pad.connect(PAD, {"x": Calibration(low=20, high=220, centre=100)})
    pad.feed([(LEFT_X, 100)], 0.0)
    assert moved(pad, (LEFT_X, 220))[0] == ("leftx", True, False, 1.0)
    assert moved(pad, (LEFT_X, 20))[0] == ("leftx", True, True, -1.0)


def test_the_layouts_own_range_and_curve_count_before_all_else() -> None:
    spec = joystick(control("leftx", minimum=100, maximum=200, deadzone=0.0, expo=0.0))
    pad = LogicalJoystick(spec)
    pad.connect(PAD, {"x": Calibration(low=0, high=20, centre=10)})
    pad.feed([(LEFT_X, 150)], 0.0)
    (event,) = pad.feed([(LEFT_X, 160)], 0.1)
    assert event.value == pytest.approx(0.2 / 0.98, abs=0.002)


def test_positions_that_the_device_does_not_have_are_passed_over() -> None:
    assert resting().feed([(99, 1), (-1, 1)], 1.0) == ()


REPORTS = st.lists(
    st.lists(
        st.one_of(
            st.tuples(st.sampled_from((LEFT_X, LEFT_Y, TRIGGER)), st.integers(-50, 300)),
            st.tuples(st.just(A), st.integers(0, 1)),
            st.tuples(st.just(HAT), st.one_of(st.none(), st.integers(0, 9))),
            st.tuples(st.just(BALL), st.integers(-127, 127)),
        ),
        max_size=4,
        unique_by=lambda value: value[0],
    ),
    max_size=20,
)


def held(events: Sequence[ControlEvent]) -> set[str]:
    """What is pressed after these; balls are never."""
    down: set[str] = set()
    for event in events:
        if event.name.endswith("wheel"):
            continue
        if event.pressed:
            assert event.repeat == (event.name in down), event
            down.add(event.name)
        else:
            assert event.name in down, event
            down.remove(event.name)
    return down


@given(reports=REPORTS, loss=st.booleans())
def test_every_press_has_its_release_also_on_loss(
    reports: list[list[tuple[int, int | None]]], *, loss: bool
) -> None:
    pad = resting()
    events = [event for report in reports for event in pad.feed(report, next(_times))]
    held(events)
    events += pad.lost() if loss else pad.release_all()
    assert held(events) == set()
    assert all(abs(event.value) <= 1.0 for event in events if not event.name.endswith("wheel"))


@given(REPORTS, REPORTS)
def test_after_release_all_nothing_that_was_deflected_counts_until_it_was_neutral(
    before: list[list[tuple[int, int | None]]], after: list[list[tuple[int, int | None]]]
) -> None:
    pad = resting()
    events = [event for report in before for event in pad.feed(report, next(_times))]
    deflected = held(events)
    pad.release_all()
    neutral: set[str] = set()
    for report in after:
        for event in pad.feed(report, next(_times)):
            name = event.name.split(" ", 2)[2]
            assert event.name not in deflected or name in neutral
        neutral |= {name for name, value in pad.values.items() if not value}
        neutral |= {f"{name} pressed" for name, value in pad.values.items() if abs(value) < 0.4}
