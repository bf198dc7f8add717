"""visualizeLink, visualizeEventLog, visualizeAlarms: what the console itself knows, in words."""

from __future__ import annotations

import dataclasses
import math

import pytest

from hub.gcm.diagnostics import Diagnostics
from hub.gcm.navigation import Assistance, MotionState
from hub.gcm.vision import ImageCoding
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.display_state import DisplayState
from rune_tui.model.robot_state import LinkPhase, PictureFlow
from rune_tui.model.theme import DARK, LIGHT
from rune_tui.model.vehicle import GONE_S
from rune_tui.visualizers.words.status_words import START_S
from rune_tui.visualizers.words.troubles import troubles
from tests.console.states import ABSENT, BROKEN, COMING
from tests.console.visualizers.conftest import NOW, made_by, words

NOTICES = (
    Notice(text="connected", when=1.0, clock="14:03:01", robot="magellan"),
    Notice(text="recording", when=2.0, clock="14:03:05"),
    Notice(text="the link is lost", when=3.0, clock="14:03:22", robot="blimp", alarm=True),
)


def rows(canvas) -> list[str]:
    return [row for row in words(canvas) if row]


@pytest.fixture
def link(made, draw):
    """The link's words on a canvas of this size."""

    def say(size, phase=LinkPhase.CONNECTED, *, age=0.1, **changes) -> list[str]:
        robot = made.robot(
            link=made.link(phase, **changes),
            navigation=made.received(made.navigation(), age),
            picture=None,
        )
        return rows(draw("visualizeLink", robot, size))

    return say


def test_the_link_tells_ages_rates_and_losses(link) -> None:
    known = {"round_trip": 0.0123, "bytes_per_s": 32e4, "messages_per_s": 21.2, "missed": 3}
    (line,) = link((120, 2), age=0.15, **known)
    assert line == (
        "linked  3 messages lost  state 0.1 s old  round trip 12 ms  21 messages/s  320 kB/s"
    )
    assert link((20, 16), age=0.15, **known) == line.split("  ")


@pytest.mark.parametrize(
    ("phase", "text"),
    [(LinkPhase.CONNECTING, "connecting 3 s"), (LinkPhase.LOST, "LINK LOST 3 s")],
)
def test_a_link_that_does_not_stand_says_so_and_tells_no_rates(link, phase, text) -> None:
    said = link((20, 16), phase, age=7.05, bytes_per_s=32e4, detail="closed by the hub")
    assert said == [text, "state 7.0 s old", "closed by the hub"]


def test_the_link_tells_who_may_only_watch(link) -> None:
    assert "may watch and stop" in link((20, 16), may_command=False)


@pytest.mark.parametrize(
    ("rate", "text"), [(12.0, "12 B/s"), (12e3, "12 kB/s"), (1.24e6, "1.2 MB/s")]
)
def test_a_rate_has_the_unit_that_fits(link, rate, text) -> None:
    assert link((20, 16), bytes_per_s=rate)[-1] == text


def test_the_links_token_changes_with_its_words(made) -> None:
    shown, state = made_by("visualizeLink"), ConsoleState(now=NOW)

    def token(**changes):
        return shown.source(made.robot(link=made.link(**changes)), state)

    assert token(round_trip=0.0121) == token(round_trip=0.0122) != token(round_trip=0.02)
    assert token() != token(detail="refused")


@pytest.fixture
def log(made, draw):
    """The rows of the log of some notices."""

    def say(size, notices=NOTICES, **options) -> list[str]:
        state = ConsoleState(now=NOW, notices=notices)
        return rows(draw("visualizeEventLog", made.robot(), size, state=state, **options))

    return say


def test_the_log_has_the_newest_at_the_bottom_and_marks_alarms(log) -> None:
    lines = [
        "14:03:01 magellan: connected",
        "14:03:05 recording",
        "14:03:22 ! blimp: the link is lost",
    ]
    assert log((60, 12)) == lines
    assert log((60, 4)) == lines[1:]
    assert log((60, 12), newest="top") == lines[::-1]


@pytest.mark.parametrize("newest", ["top", "bottom"])
def test_a_long_notice_is_wrapped_and_begins_where_it_is_read_first(log, newest) -> None:
    lost = NOTICES[-1]
    lines = ["14:03 ! blimp: the", "    link is lost"]
    assert log((20, 4), (lost,), newest=newest) == lines
    assert log((25, 2), (lost,), newest=newest) == ["14:03 ! blimp: link lost"]
    assert log((20, 2), (lost,), newest=newest) == ["14:03 ! blimp: link…"]
    assert len(log((25, 4), newest=newest)) == 2, "a row each"


def told(text: str, age: float, **how) -> Notice:
    return Notice(text=text, when=NOW - age, clock="14:03:22", **how)


def test_a_notice_takes_two_rows_at_most_and_of_paths_the_file_alone(log) -> None:
    long = "recording into /home/jane/Documents/Rune/run1.mcap " + "and on " * 20
    lines = log((40, 20), (told(long, 1.0),))
    (line,) = lines
    assert "…/run1.mcap" in line
    assert line.endswith("…")


def test_a_refusal_is_not_pushed_out_by_files_within_ten_seconds(log) -> None:
    refused = told("you may not", 9.0, alarm=True)
    unmarked = told("not marked: no ground there", 8.0)
    files = tuple(told(f"file {number}", 1.0, routine=True) for number in range(5))
    shown = log((60, 6), (refused, unmarked, *files))
    assert [line.split(" ", 1)[1] for line in shown] == [
        "! you may not",
        "not marked: no ground there",
        "file 4",
    ]
    old = told("you may not", 11.0, alarm=True)
    assert "you may not" not in "".join(log((60, 4), (old, *files)))


def test_what_is_said_again_and_again_takes_one_row(log) -> None:
    again = tuple(told("refused", age) for age in (3.0, 2.0, 1.0))
    assert log((60, 12), again) == ["14:03:22 refused (3 times)"]


def test_the_log_of_one_robot_leaves_out_the_others(log) -> None:
    assert log((60, 12), robots="its own") == [
        "14:03:01 magellan: connected",
        "14:03:05 recording",
    ]


def test_an_empty_log_says_so(log) -> None:
    assert log((60, 12), ()) == ["no events yet"]


def test_the_logs_token_changes_with_its_notices_only(made) -> None:
    shown, robot = made_by("visualizeEventLog", robots="its own"), made.robot()

    def token(now, notices, theme=DARK):
        return shown.source(robot, ConsoleState(now=now, notices=notices, theme=theme))

    assert token(NOW, NOTICES[:2]) == token(NOW + 5, NOTICES) != token(NOW, NOTICES[:1])
    assert token(NOW, NOTICES) != token(NOW, NOTICES, LIGHT)


@pytest.fixture
def alarms(made, draw):
    """The rows of the annunciator."""

    def say(size=(60, 20), *, age=0.1, link=None, **changes) -> list[str]:
        robot = made.robot(
            navigation=made.received(made.navigation(**changes), age), link=link or made.link()
        )
        return rows(draw("visualizeAlarms", robot, size))

    return say


def test_nothing_wrong_is_told_quietly(made, draw, alarms) -> None:
    assert alarms() == ["magellan: all well"]
    assert (draw("visualizeAlarms", made.robot(), (30, 4)).pixels == DARK.panel).all()


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"age": 1.5}, "!! STATE 1.5 s OLD"),
        ({"battery_fraction": 0.15}, "! BATTERY LOW 15% 24.1 V"),
        ({"battery_fraction": 0.05}, "!! BATTERY CRITICAL 5% 24.1 V"),
        ({"motion": MotionState.SILENCE}, "!! STOPPED: commands fell silent"),
        ({"motion": MotionState.NO_DRIVER}, "!! NO DRIVER: cannot move"),
        ({"bumpers": 0b11}, "!! BUMPER PRESSED ahead"),
        ({"bumpers": 1 << 4 | 1 << 8}, "!! BUMPER PRESSED left and behind"),
        ({"assistance": Assistance.OFF}, "! ASSISTANCE OFF: it drives into walls"),
    ],
)
def test_every_trouble_is_told_in_words_with_its_sign(alarms, changes, text) -> None:
    assert alarms(**changes) == [text]


def test_what_a_bumper_said_long_ago_is_no_alarm_now(alarms) -> None:
    assert alarms(age=9.0, bumpers=0b11, assistance=Assistance.OFF) == ["!! STATE 9.0 s OLD"]


def test_marks_that_another_robot_does_not_confirm_are_its_own_trouble(made) -> None:
    state = ConsoleState(now=NOW, overdue={(1, "magellan"): 1, (2, "blimp"): 2})
    texts = [part.text for part in troubles(made.robot(), state)]
    assert texts == ["NOT CONFIRMED BY THE ROBOT: 1 mark"]


def test_a_lost_link_and_a_wanted_capability_that_is_missing_are_told(made, alarms) -> None:
    link = made.link(LinkPhase.LOST, lacking={"VIS_VID": BROKEN})
    missing = "! VIS_VID MISSING: its modules cannot be started"
    assert alarms((60, 8), link=link) == ["!! LINK LOST 3 s", missing]


def test_a_capability_that_the_robot_is_made_without_is_no_alarm(made, alarms) -> None:
    assert alarms(link=made.link(lacking={"PRO_MAP": ABSENT})) == ["magellan: all well"]


def test_a_robot_whose_problems_are_not_reported_is_not_called_well(made, draw) -> None:
    for heard in ({}, {1: made.received(Diagnostics(), GONE_S)}):
        for since, said in (
            (NOW - START_S, "! its problems are not known: no module reports them"),
            (NOW - 0.9 * START_S, "magellan: not known yet"),
        ):
            robot = made.robot(diagnostics=heard, link=made.link(since=since))
            assert rows(draw("visualizeAlarms", robot, (60, 4))) == [said]


def test_a_module_that_starts_is_an_alarm_only_if_it_takes_long(made, alarms) -> None:
    link = made.link(lacking={"VIS_VID": COMING}, since=NOW - 0.9 * START_S)
    assert alarms(link=link) == ["magellan: all well"]
    link = dataclasses.replace(link, since=NOW - 1.1 * START_S)
    assert alarms(link=link) == ["! VIS_VID MISSING: not started yet"]


def test_a_robot_that_never_told_its_state_is_not_well(made, draw) -> None:
    canvas = draw("visualizeAlarms", made.robot(navigation=None), (40, 4))
    assert rows(canvas) == ["! no robot state yet"]


def test_the_worst_comes_first_and_the_rest_is_counted(made, alarms) -> None:
    link = made.link(lacking={"VIS_VID": COMING}, since=NOW - 60.0)
    wrong = {"battery_fraction": 0.05, "assistance": Assistance.OFF, "age": 1.5}
    assert alarms((40, 8), link=link, **wrong) == [
        "!! STATE 1.5 s OLD",
        "!! BATTERY CRITICAL 5% 24.1 V",
        "! ASSISTANCE OFF: it drives into walls",
        "! VIS_VID MISSING: not started yet",
    ]
    assert alarms((40, 4), link=link, **wrong)[1].endswith(" +2")
    assert alarms((20, 4), link=link, **wrong)[1] == "!! BATTERY CRITICAL…"
    assert alarms((20, 2), link=link, **wrong) == ["!! STATE 1.5 s OLD"]
    assert alarms((12, 2), link=link, **wrong) == ["!! STATE…"]


def test_alarms_lie_on_the_alarms_colour_and_warnings_do_not(made, draw) -> None:
    wrong = made.navigation(battery_fraction=0.05, assistance=Assistance.OFF)
    robot = made.robot(navigation=made.received(wrong))
    canvas = draw("visualizeAlarms", robot, (40, 4))
    assert (canvas.pixels[:2] == DARK.alarm).all()
    assert (canvas.pixels[2:] == DARK.panel).all()


def test_the_token_of_alarms_changes_with_their_words_only(made) -> None:
    shown, state = made_by("visualizeAlarms"), ConsoleState(now=NOW)

    def token(**changes):
        return shown.source(made.robot(navigation=made.received(made.navigation(**changes))), state)

    assert token(linear=0.5) == token() != token(battery_fraction=0.05)
    light = dataclasses.replace(state, theme=LIGHT)
    assert shown.source(made.robot(), state) != shown.source(made.robot(), light)


@pytest.mark.parametrize(
    ("age", "text"), [(0.31, "picture 0.3 s old"), (0.49, "picture 0.4 s old")]
)
def test_a_picture_of_less_than_half_a_second_is_told_calmly(made, draw, age, text) -> None:
    assert picture_row(made, draw, age) == (text, DARK.ink)


def test_a_picture_of_more_than_half_a_second_is_told_in_red_and_louder_words(made, draw) -> None:
    assert picture_row(made, draw, 0.61) == ("PICTURE 0.6 s OLD", DARK.alarm_ink)


def test_a_picture_is_late_only_after_the_time_of_the_next_one(made, draw) -> None:
    assert picture_row(made, draw, 0.81, interval=0.7) == ("picture 0.8 s old", DARK.ink)
    assert picture_row(made, draw, 0.91, interval=0.7) == ("PICTURE 0.9 s OLD", DARK.alarm_ink)


def picture_row(made, draw, age, interval=0.0):
    """What the link says of a picture of this age [s], and in what colour."""
    picture = dataclasses.replace(made.picture(), interval_s=interval)
    robot = made.robot(link=made.link(), navigation=None, picture=made.received(picture, age))
    canvas = draw("visualizeLink", robot, (20, 16))
    (row,) = [at for at, text in enumerate(words(canvas)) if "picture" in text.lower()]
    return words(canvas)[row], tuple(canvas.ink[row, 0].tolist())


def test_the_link_tells_how_pictures_come_and_that_they_were_made_smaller(link) -> None:
    flow = PictureFlow(
        coding=ImageCoding.WEBP, quality=20, width_px=80, height_px=48, shrunk=False, per_s=6.2
    )
    assert link((20, 16), pictures=flow)[2:] == ["6 pictures/s", "80x48 WEBP 20"]
    shrunk = dataclasses.replace(flow, shrunk=True)
    assert "pictures made smaller for the link" in " ".join(link((60, 16), pictures=shrunk))
    assert link((20, 16), LinkPhase.LOST, pictures=flow)[0].startswith("LINK LOST")
    assert "6 pictures/s" not in link((20, 16), LinkPhase.LOST, pictures=flow)


@pytest.mark.parametrize(
    ("latency", "coarseness", "wanted"),
    [
        (0.043, 0, ["terminal 40 ms behind"]),
        (0.62, 5, ["TERMINAL 620 ms BEHIND", "drawn coarser for the terminal"]),
        (math.nan, 2, []),
    ],
)
def test_the_link_tells_how_far_the_terminal_is_behind(
    made, draw, latency, coarseness, wanted
) -> None:
    display = DisplayState(
        latency=latency, frames_per_s=15.0, bytes_per_s=1e5, coarseness=coarseness
    )
    robot = made.robot(link=made.link(), navigation=None)
    told = words(
        draw("visualizeLink", robot, (34, 16), state=ConsoleState(now=NOW, display=display))
    )
    assert [text for text in told if "terminal" in text.lower()] == wanted


def test_a_pictures_age_is_that_which_the_operator_sees(made, draw) -> None:
    display = DisplayState(latency=0.5, frames_per_s=15.0, bytes_per_s=1e5, coarseness=0)
    robot = made.robot(link=made.link(), picture=made.received(made.picture(), 0.31))
    for name in ("visualizeLink", "visualizeStatus"):
        told = " ".join(
            words(draw(name, robot, (160, 16), state=ConsoleState(now=NOW, display=display)))
        )
        assert "PICTURE 0.8 s OLD" in told
