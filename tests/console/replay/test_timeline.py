"""The timeline has each moment at its place, and what happened in a recording."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints, PointKind
from hub.gcm.navigation import ROBOT_STATE
from hub.recording.recording_set import RecordingSet
from rune_tui.files.console_recording import ConsoleRecording
from rune_tui.model.own_records import RUNE_INPUT, InputOutcome, InputRecord
from rune_tui.model.team_events import RUNE_TEAM, TeamEvent, TeamEventKind
from rune_tui.replay.desk import entered
from rune_tui.replay.source import EventKind, Overview, ReplayEvent, Span
from rune_tui.replay.survey import survey
from rune_tui.replay.timeline import (
    clock_text,
    column_of,
    marks_row,
    pointer_row,
    rate_text,
    stamp_of,
)
from tests.support.messages import robot_state

SECOND = 1_000_000_000
KEY = InputRecord(
    t_read=0.0,
    input="w",
    pressed=True,
    repeat=False,
    value=1.0,
    viewport="",
    x=np.nan,
    y=np.nan,
    in_picture=False,
    handlers=("SetSpeed",),
    robot="blimp",
    outcome=InputOutcome.SENT,
)


@given(st.integers(1, 400), st.data())
def test_a_click_on_a_column_leads_to_a_time_of_this_column(
    width: int, data: st.DataObject
) -> None:
    column = data.draw(st.integers(0, width - 1))
    start = data.draw(st.integers(0, 2**60))
    end = start + data.draw(st.integers(1000 * SECOND, 100_000 * SECOND))
    assert column_of(stamp_of(column, start, end, width), start, end, width) == column


@given(st.integers(1, 200), st.integers(0, 2**60), st.integers(0, 2**45), st.integers())
def test_rows_are_as_long_as_the_terminal_is_wide(
    width: int, start: int, length: int, place: int
) -> None:
    event = ReplayEvent(stamp=place, kind=EventKind.BUMP)
    overview = Overview(events=[event], episodes=[Span(start=place, end=start + length)])
    here = start + min(max(place, 0), length)
    assert len(marks_row(width, start, start + length, here, overview)) == width
    pointer = pointer_row(width, start, start + length, here, (" RECORDING 1:00 ", " 1:00 "))
    assert len(pointer) == width
    assert pointer.count("▲") == 1


def test_the_most_important_event_of_a_column_is_shown() -> None:
    kinds = [EventKind.NOTE, EventKind.ALARM, EventKind.BUMP]
    events = [ReplayEvent(stamp=5, kind=kind) for kind in kinds]
    overview = Overview(
        events=events, episodes=[Span(start=0, end=40)], gaps=[Span(start=60, end=80)]
    )
    assert marks_row(10, 0, 100, 99, overview) == "!▂▂▂▂ ╱╱╱█"


def test_times_are_read_as_people_write_them() -> None:
    assert entered("90", 0) == 90 * SECOND == entered("1:30", 0)
    assert entered("1:02:30.5", SECOND) == 3_751_500_000_000
    assert [entered(text, 0) for text in ("", "a", "1:2:3:4", ":", "1:-")] == [None] * 5
    assert (clock_text(245.04), clock_text(3723.4)) == ("4:05.0", "1:02:03.4")
    assert (rate_text(10.0, 9.8), rate_text(100.0, 27.2)) == ("x10", "x100 (reaches x27)")


def test_what_happened_is_found(tmp_path: Path) -> None:
    path, now = tmp_path / "a.mcap", 100.0
    recording = ConsoleRecording(path, {}, clock=lambda: now)
    point = InterestPoint(
        number=1, kind=PointKind.VICTIM, x=1.0, y=2.0, thumbnail=np.zeros(0, np.uint8)
    )
    bumps = {103.0: 1, 103.1: 0, 103.5: 1, 103.6: 0, 106.0: 2}
    presses = (101.0, 101.5, 102.0, 106.0)
    for tick in range(300):
        now = 100.0 + tick / 10
        if 110.0 < now < 115.0:
            continue
        near = round(now, 1)
        state = dataclasses.replace(robot_state(), bumpers=bumps.get(near, 0))
        if near in (100.0, 118.0):  # the console waits for the first state; later one is late
            silent = TeamEvent(kind=TeamEventKind.RAISED, robot="blimp", cause="state")
            recording.add("console", RUNE_TEAM, silent, now)
        recording.add("blimp", ROBOT_STATE, state, now)
        if near in presses:
            recording.add("console", RUNE_INPUT, KEY, now)
        if near in (100.5, 107.0, 108.0):
            points = InterestPoints(points=(point,) if near > 101.0 else ())
            recording.add("blimp", INTEREST_POINTS, points, now)
        if near == 120.0:
            raised = TeamEvent(kind=TeamEventKind.RAISED, robot="blimp", cause="leak")
            recording.add("console", RUNE_TEAM, raised, now)
    recording.close()
    with RecordingSet.open([path]) as opened:
        found, start = survey(opened), opened.start
    times = [(round((each.stamp - start) / SECOND, 1), each.kind.value) for each in found.events]
    assert times == [(3.0, "B"), (6.0, "B"), (7.0, "V"), (18.0, "!"), (20.0, "!")]
    spans = [
        ((each.start - start) / SECOND, (each.end - start) / SECOND) for each in found.episodes
    ]
    assert [(round(one, 1), round(two, 1)) for one, two in spans] == [(1.0, 2.0), (6.0, 6.5)]
    (gap,) = found.gaps
    assert round((gap.start - start) / SECOND, 1) == 10.0
    assert round((gap.end - start) / SECOND, 1) == 15.0


def test_a_held_key_is_an_episode_of_its_whole_length(tmp_path: Path) -> None:
    """A terminal that reports releases repeats only the key that went down last."""
    path, now = tmp_path / "a.mcap", 100.0
    recording = ConsoleRecording(path, {}, clock=lambda: now)
    released = dataclasses.replace(KEY, pressed=False, outcome=InputOutcome.SENT)
    turning = dataclasses.replace(KEY, input="a")
    for now, key in ((100.0, KEY), (121.0, released), (140.0, turning)):
        recording.add("console", RUNE_INPUT, key, now)
    now = 150.0
    recording.add("blimp", ROBOT_STATE, robot_state(), now)
    recording.close()
    with RecordingSet.open([path]) as opened:
        found, start = survey(opened), opened.start
    ends = [((span.start - start) / SECOND, (span.end - start) / SECOND) for span in found.episodes]
    assert [(round(one), round(two)) for one, two in ends] == [(0, 21), (40, 50)]
