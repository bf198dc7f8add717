"""visualizePlot: a number over time, and the history behind it."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.navigation import ROBOT_STATE, STOP, MotionState, Stop
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Received
from rune_tui.model.theme import DARK, LIGHT
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.history import SLOTS, History, number_at
from tests.console.states import range_readings, robot_of
from tests.console.visualizers.conftest import made_by, words
from tests.console.visualizers.known import point, points
from tests.support.cases import for_each


class Watched:
    """A plot that is looked at each time a value comes."""

    def __init__(self, made, **options):
        self.made = made
        self.plot = made_by("visualizePlot", **options)
        self.number = 0
        self.robot = made.robot(navigation=None)

    def see(self, when: float, name: str = "magellan", **changes) -> None:
        """One more robot state, measured then."""
        self.number += 1
        value = self.made.navigation(**changes)
        received = Received(value=value, measured=when, number=self.number)
        self.robot = robot_of(name=name, link=self.made.link(), navigation=received)
        self.plot.source(self.robot, ConsoleState(now=when))

    def drawn(self, now: float, size: tuple[int, int] = (40, 22)) -> Canvas:
        canvas = Canvas.blank(*size)
        self.plot.draw(canvas, self.robot, ConsoleState(now=now))
        return canvas


@pytest.fixture
def watched(made):
    return lambda **options: Watched(made, **options)


def line(canvas: Canvas) -> np.ndarray:
    """Where the line is: rows and columns of pixels."""
    return (canvas.pixels == DARK.accent).all(axis=2)


def test_a_plot_without_data_says_what_it_waits_for(watched) -> None:
    shown = " ".join(" ".join(words(watched().drawn(1.0))).split())
    assert shown == "no GCM_RobotState from magellan"


def test_a_field_that_is_not_there_is_named(watched) -> None:
    plot = watched(field="sonar[99]")
    plot.see(1.0)
    shown = " ".join(" ".join(words(plot.drawn(1.0))).split())
    assert shown == "GCM_RobotState has no number sonar[99]"


def test_the_line_runs_from_long_ago_at_the_left_to_now_at_the_right(watched) -> None:
    plot = watched(field="linear", seconds=10.0, least=0.0, most=1.0)
    for step in range(201):
        plot.see(step * 0.05, linear=step / 200)
    where = line(plot.drawn(10.0))
    heights = where.argmax(axis=0)
    assert where.any(axis=0).all()
    assert (np.diff(heights) <= 0).all()
    assert heights[0] > 19
    assert heights[-1] == 2


def test_what_is_missing_is_left_out(watched) -> None:
    plot = watched(seconds=10.0, least=0.0, most=1.0)
    for step in range(201):
        if not 80 < step < 120:
            plot.see(step * 0.05, linear=0.5)
    empty = np.flatnonzero(~line(plot.drawn(10.0)).any(axis=0))
    assert set(range(18, 23)) <= set(empty) <= set(range(15, 25))


def test_what_is_not_a_number_is_a_gap(watched) -> None:
    plot = watched(seconds=10.0, least=0.0, most=1.0)
    for when, value in ((2.0, 0.5), (2.5, math.nan), (3.0, 0.5)):
        plot.see(when, linear=value)
    assert line(plot.drawn(3.0)).sum() == 2


def test_a_spike_within_one_pixel_is_drawn_in_full(watched) -> None:
    plot = watched(seconds=40.0, least=0.0, most=1.0)
    for when, value in ((1.1, 0.5), (1.3, 1.0), (1.5, 0.0), (1.7, 0.5)):
        plot.see(when, linear=value)
    assert line(plot.drawn(1.9)).sum(axis=0).max() == 20


@pytest.mark.parametrize(("seconds", "columns"), [(40.0, 2), (10.0, 5)])
def test_values_are_joined_whatever_their_distance(watched, seconds, columns) -> None:
    plot = watched(seconds=seconds, least=0.0, most=1.0)
    for when, value in ((1.1, 0.0), (2.1, 1.0)):
        plot.see(when, linear=value)
    where = line(plot.drawn(2.2))
    assert where[2:].any(axis=1).all()
    assert where.any(axis=0).sum() == columns


def test_silence_grows_as_a_gap_at_the_right_and_is_called_stale(watched) -> None:
    plot = watched(seconds=10.0, least=0.0, most=1.0)
    for step in range(101):
        plot.see(step * 0.05, linear=0.5)
    fresh, old, stale = (plot.drawn(now) for now in (5.9, 6.1, 9.25))
    assert fresh.ink.sum() > old.ink.sum()
    assert "STALE 4.2 s" in words(stale)[0]
    assert not line(plot.drawn(5.9))[:, -3:].any()


def test_the_range_is_found_where_the_layout_gives_none(watched) -> None:
    plot = watched(field="theta", seconds=10.0)
    for step in range(21):
        plot.see(step * 0.05, theta=step / 10 - 1)
    where = line(plot.drawn(1.0))
    assert where[2].any()
    assert where[-1].any()
    assert [row.split()[0] for row in words(plot.drawn(1.0))[1::9]] == ["1", "-1"]


def test_a_number_that_never_changes_lies_amid(watched) -> None:
    plot = watched(seconds=10.0)
    plot.see(1.0, linear=0.0)
    assert np.flatnonzero(line(plot.drawn(1.0)).any(axis=1)).tolist() == [12]


@pytest.mark.parametrize(
    ("width", "text"),
    [
        (80, "GCM_RobotState linear 0.25, 0 to 1 in 30 s"),
        (20, "linear 0.25, 30 s"),
        (12, "linear 0.25"),
        (4, "0.25"),
    ],
)
def test_the_newest_value_is_told_in_the_room_there_is(watched, width, text) -> None:
    plot = watched(least=0.0, most=1.0)
    plot.see(1.0, linear=0.25)
    assert words(plot.drawn(1.0, (width, 2)))[0] == text


def test_each_robot_has_a_line_of_its_own(watched) -> None:
    plot = watched(seconds=10.0, least=0.0, most=1.0)
    plot.see(4.0, "magellan", linear=0.0)
    plot.see(5.0, "blimp", linear=1.0)
    assert np.flatnonzero(line(plot.drawn(5.0)).any(axis=1)).tolist() == [2]


def test_any_message_can_be_drawn_and_events_never_are_stale(made, draw) -> None:
    robot = made.robot(messages={STOP.name: made.received(Stop(reason="x"), 60.0)})
    shown = words(draw("visualizePlot", robot, (60, 4), message=STOP.name, field="reason"))
    assert "GCM_Stop has no number reason" in " ".join(shown)
    assert "STALE" not in " ".join(shown)


def test_the_token_changes_with_values_and_pixels_of_time_only(watched) -> None:
    plot = watched(seconds=20.0)
    plot.see(1.0)
    plot.drawn(1.0)

    def token(now: float, theme=DARK):
        return plot.plot.source(plot.robot, ConsoleState(now=now, theme=theme))

    assert token(1.1) == token(1.4) != token(1.6)
    assert token(1.1) != token(1.1, LIGHT)
    before = token(1.4)
    plot.see(1.4)
    assert token(1.4) != before
    assert token(4.55) != token(4.65)


def test_numbers_are_found_by_their_path(made) -> None:
    value = made.navigation(motion=MotionState.MOVING)
    assert number_at(value, "battery_voltage") == 24.1
    readings = range_readings(sonar=np.arange(16, dtype=np.float32))
    assert number_at(readings, "scans[0].ranges[3]") == 3.0
    assert number_at(value, "motion") == 1.0
    assert number_at(points(point(1), point(2)), "points[1].number") == 2.0


@for_each(
    "path",
    [
        *("", ".", "nothing", "scans", "scans[9]", "scans[-1]", "scans[x]", "scans[0", "scans[]"),
        *("__class__", "scans[0].ranges[16]", "scans[0].ranges.size", "scans[0][0]", "scans[²]"),
    ],
)
def test_a_path_that_leads_to_no_number_finds_none(made, path) -> None:
    assert number_at(range_readings(sonar=1.0), path) is None
    assert number_at(made.navigation(), path) is None


@given(st.text("abs[]019._²", max_size=12))
def test_no_path_breaks_the_plot(path: str) -> None:
    value = points(point(1))
    assert number_at(value, path) is None or isinstance(number_at(value, path), float)


@given(st.lists(st.tuples(st.floats(0.001, 2.0), st.floats(-1e3, 1e3)), min_size=1, max_size=60))
def test_history_keeps_extremes_order_and_gaps(steps: list[tuple[float, float]]) -> None:
    history = History(10.0, gap=1.0)
    now, gaps = 0.0, 0
    for step, value in steps:
        gaps += now > 0.0 and (now + step) - now > 1.0
        now += step
        history.add(now, value)
    slots = list(history.since(0.0))
    values = [value for _, value in steps]
    assert min(slot.low for slot in slots) == min(values)
    assert max(slot.high for slot in slots) == max(values)
    assert (slots[0].first, slots[-1].last) == (values[0], values[-1])
    assert all(a.end <= b.begin for a, b in itertools.pairwise(slots))
    assert sum(not slot.joined for slot in slots) == gaps + 1


def test_history_stays_bounded_however_much_comes() -> None:
    history = History(30.0, gap=1.0)
    for step in range(20_000):
        history.add(step * 0.01, 0.0)
    kept = list(history.since(0.0))
    assert len(kept) <= SLOTS
    assert kept[0].begin < 200.0 - 29.0


def test_a_clock_that_jumps_back_joins_nothing() -> None:
    history = History(30.0, gap=1.0)
    for when in (5.0, 4.9):
        history.add(when, 0.0)
    assert [slot.joined for slot in history.since(0.0)] == [False, False]


def test_a_plot_ignores_a_message_that_it_has_seen(watched) -> None:
    plot = watched()
    plot.see(1.0)
    state = ConsoleState(now=1.0)
    first = plot.plot.source(plot.robot, state)
    same = dataclasses.replace(plot.robot)
    assert plot.plot.source(same, state) == first
    assert plot.robot.newest(ROBOT_STATE) is not None
