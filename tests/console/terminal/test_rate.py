"""How pictures are drawn on ways of different width, on a model of the way and of the pictures."""

from __future__ import annotations

import heapq
import math
import statistics
from collections.abc import Callable
from dataclasses import dataclass, field

from rune_tui.terminal.input_stream import CursorReport
from rune_tui.terminal.pacing import FramePacer
from rune_tui.terminal.rate import LADDER, RateController
from tests.support.cases import for_each

PAN = (282e3, 160e3, 98e3, 51e3, 33e3, 24e3, 9e3, 3e3)
"""Bytes of a picture from a moving camera, 160x48 cells, each way of the ladder."""
STILL = (0.0,) * 8


@dataclass
class Run:
    """What came of it."""

    ages: list[float] = field(default_factory=list)
    levels: list[int] = field(default_factory=list)
    sizes: list[float] = field(default_factory=list)
    lasted: float = 0.0

    @property
    def fps(self) -> float:
        return len(self.ages) / self.lasted


def run(
    sizes: Callable[[float], tuple[float, ...]],
    width: float | Callable[[float], float],
    trip: float,
    *,
    seconds: float = 10.0,
    fps: float = 30.0,
    most: float = math.inf,
) -> Run:
    """Frames over a way of so many bytes/s and a round trip [s], buffers without end."""
    pacer, control, done = FramePacer(heard=True), RateController(trip, most), Run(lasted=seconds)
    free = 0.0
    answers: list[tuple[float, int, CursorReport, float]] = []
    for tick in range(round(seconds * fps)):
        now = tick / fps
        while answers and answers[0][0] <= now:
            at, _, report, drawn = heapq.heappop(answers)
            answer = pacer.answered(at, report)
            assert answer is not None
            control.acknowledged(at, answer)
            done.ages.append(at - trip / 2 - drawn)
        if not pacer.may_send(now) or not control.may_follow(now, pacer.under_way):
            continue
        size = sizes(now)[control.level]
        while control.too_long(size):
            size = sizes(now)[control.level]
        if not size:
            continue
        done.levels.append(control.level)
        done.sizes.append(size)
        control.drawn(size)
        question = pacer.sent(now, round(size))
        column = int(question.partition(";")[2].partition("H")[0])
        rate = width(now) if callable(width) else width
        free = max(free, now) + size / rate
        heapq.heappush(answers, (free + trip, tick, CursorReport(row=2, column=column), now))
    return done


@for_each(
    ("width", "trip", "least_fps", "median", "longest"),
    [
        (20e6, 0.001, 25.0, 0.05, 0.1),
        (2e6, 0.04, 12.0, 0.1, 0.3),
        (0.5e6, 0.04, 8.0, 0.25, 0.6),
        (100 * 1024, 0.04, 3.0, 0.4, 1.2),
        (20e3, 0.2, 2.0, 0.6, 3.0),
    ],
)
def test_on_any_way_what_is_seen_is_new(
    width: float, trip: float, least_fps: float, median: float, longest: float
) -> None:
    done = run(lambda _: PAN, width, trip)
    settled = done.ages[len(done.ages) // 3 :]
    assert done.fps >= least_fps
    assert statistics.median(settled) <= median
    assert max(done.ages) <= longest


def test_a_wide_way_shows_everything_exactly() -> None:
    assert run(lambda _: PAN, 50e6, 0.001).levels[-1] == 0


def test_colours_go_first_then_frames_and_pixels_last() -> None:
    ways = [run(lambda _: PAN, width, 0.04) for width in (50e6, 1e6, 0.5e6, 0.1e6, 0.02e6)]
    levels = [statistics.median(done.levels[len(done.levels) // 2 :]) for done in ways]
    assert levels == sorted(levels)
    grains = [LADDER[int(level)].grain for level in levels]
    assert grains[:4] == [1, 1, 1, 1]
    assert ways[3].fps < ways[1].fps
    assert grains[4] > 1


def test_a_way_that_becomes_narrow_is_noticed_within_two_seconds() -> None:
    done = run(lambda _: PAN, lambda now: 5e6 if now < 5.0 else 0.2e6, 0.04, seconds=15.0)
    late = done.ages[-20:]
    assert statistics.median(late) <= 0.3


def test_a_scene_that_begins_to_move_does_not_choke_the_way() -> None:
    done = run(lambda now: STILL if now < 5.0 else PAN, 0.5e6, 0.04)
    assert max(done.ages) <= 0.6


def test_no_frame_is_longer_than_a_multiplexer_keeps() -> None:
    done = run(lambda _: PAN, 50e6, 0.001, most=60e3)
    assert max(done.sizes) <= 60e3
    assert LADDER[done.levels[-1]].tolerance == 8
