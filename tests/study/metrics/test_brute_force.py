"""Metrics beside what their definitions say, word for word, tick by tick.

Times are ticks of an eighth of a second, which floating point keeps exactly.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.metrics.bumps import SIXTEEN, bumps
from rune_study.metrics.driving import camera_off_centre
from rune_study.metrics.effectiveness import Signal
from rune_study.metrics.episodes import Episode, covered, episodes
from rune_study.metrics.latency import motion_to_photon
from rune_study.metrics.neglect import neglects
from rune_study.metrics.victims import Mark, first_victim, victims_found
from rune_study.statistics.survival import kaplan_meier

TICK = 0.125
TICKS = st.integers(0, 240)
PLACES = st.tuples(st.integers(0, 24), st.integers(0, 24))


@given(
    st.lists(st.sampled_from([0, 1, 4, 15, 16, 17, 30]), max_size=14),
    st.lists(TICKS, max_size=6),
)
def test_episodes(pauses: list[int], chosen: list[int]) -> None:
    inputs = list(itertools.accumulate(pauses))
    made = episodes([TICK * each for each in inputs], [TICK * each for each in chosen])
    groups: list[list[int]] = []
    for each in sorted(inputs):
        if groups and each - groups[-1][-1] <= 16:  # 2 s
            groups[-1].append(each)
        else:
            groups.append([each])
    wanted: list[tuple[int, int, int]] = []
    for group in groups:
        begin = max((each for each in chosen if 0 <= group[0] - each <= 16), default=group[0])
        before = wanted[-1][1] if wanted else 0
        wanted.append((max(begin, before), max(group[-1], group[0] + 4), len(group)))
    assert [(each.begin / TICK, each.end / TICK, each.inputs) for each in made] == wanted


@given(
    st.lists(st.sampled_from([1, 3, 4, 5, 23, 24, 25, 40]), min_size=1, max_size=30),
    st.lists(TICKS, min_size=2, max_size=8, unique=True),
)
def test_neglects(runs: list[int], cuts: list[int]) -> None:
    low = [place % 2 == 1 for place, run in enumerate(runs) for _ in range(run)][:240]
    low += [False] * (240 - len(low))
    cuts = sorted(cuts)
    served = list(zip(cuts[::2], cuts[1::2], strict=False))
    rate = Signal(times=np.arange(240) * TICK, values=1.0 - np.array(low, float))
    spans = [Episode(begin=a * TICK, end=b * TICK, inputs=1) for a, b in served]
    made = neglects(spans, rate, 30.0, 0.5)
    for place, (_, left) in enumerate(served):
        returned = place + 1 < len(served) and served[place + 1][0] < 240
        stop = served[place + 1][0] if returned else 240
        drop = next(
            (
                tick
                for tick in range(left, stop)
                if (tick + 24 <= stop and all(low[tick : tick + 24]))  # 3 s
                or (returned and stop - tick >= 4 and all(low[tick:stop]))
            ),
            None,
        )
        wanted = (stop - left, False) if drop is None else (drop - left, True)
        assert (made[place].length / TICK, made[place].seen) == wanted


@given(st.lists(st.tuples(TICKS, TICKS), max_size=6))
def test_union_of_attention(ends: list[tuple[int, int]]) -> None:
    total = sum(any(a <= tick < b for a, b in ends) for tick in range(20, 200))
    spans = [(a * TICK, b * TICK) for a, b in ends]
    assert covered(spans, 20 * TICK, 200 * TICK) == total * TICK


@given(st.lists(PLACES, max_size=5), st.lists(PLACES, max_size=4), st.sampled_from([5, 8, 10]))
def test_victims(marks, places, radius: int) -> None:
    near = {
        (mark, place): math.dist(marks[mark], places[place])
        for mark in range(len(marks))
        for place in range(len(places))
        if math.dist(marks[mark], places[place]) <= radius
    }
    best = (0, 0.0)
    for size in range(1, min(len(marks), len(places)) + 1):
        for chosen in itertools.combinations(near, size):
            if all(len({pair[side] for pair in chosen}) == size for side in (0, 1)):
                best = min(best, (-size, sum(near[pair] for pair in chosen)))
    found = victims_found(
        [Mark(time=0.0, x=x * TICK, y=y * TICK) for x, y in marks],
        np.multiply(places, TICK) if places else [],
        radius * TICK,
    )
    assert (found.found, found.false) == (-best[0], len(marks) + best[0])
    if found.found:
        assert found.error == pytest.approx(best[1] * TICK / found.found)
    first = first_victim(
        [Mark(time=float(at), x=x * TICK, y=y * TICK) for at, (x, y) in enumerate(marks)],
        np.multiply(places, TICK) if places else [],
        60.0,
        radius * TICK,
    )
    if places:
        assert first.value == min((mark for mark, _ in near), default=60)
        assert first.censored is not bool(near)


@given(
    st.lists(
        st.tuples(st.integers(1, 12), st.booleans(), st.integers(0, 65535), st.booleans()),
        min_size=1,
        max_size=30,
    )
)
def test_bumps(rows) -> None:
    at = np.cumsum([each[0] for each in rows]) * TICK
    wanted = {"front": 0, "rear": 0, "side": 0}
    last = -math.inf
    for place, (_, rises, bits, back) in enumerate(rows):
        if place and rises and at[place] - last >= 1.0:
            last = at[place]
            pressed = [angle for bit, angle in enumerate(SIXTEEN) if bits >> bit & 1]
            total = sum(complex(math.cos(each), math.sin(each)) for each in pressed)
            away = abs(math.degrees(math.atan2(total.imag, total.real))) if total else 0.0
            side = "front" if away <= 67.5001 else "rear" if away >= 112.4999 else "side"
            if abs(total) < 1e-6:
                side = "rear" if back else "front"
            wanted[side] += 1
    counts = np.cumsum([each[1] for each in rows])
    speeds = [-0.1 if each[3] else 0.1 for each in rows]
    found = bumps(at, counts, [each[2] for each in rows], speeds)
    assert {side: getattr(found, side) for side in wanted} == wanted


@given(
    st.lists(
        st.tuples(
            st.integers(0, 20),
            st.sampled_from([-16, -15, 0, 15, 16]),
            st.sampled_from([0.0, 0.05, -0.06]),
            st.sampled_from([0.0, 0.1, -0.2]),
        ),
        max_size=12,
    )
)
def test_camera_off_centre(rows) -> None:
    driven = aside = 0
    for ticks, pan, linear, angular in rows:
        if abs(linear) > 0.05 or abs(angular) > 0.1:
            driven += ticks
            aside += ticks if abs(pan) > 15 else 0  # exactly 15 deg is centred
    widths, pans, linears, angulars = zip(*rows, strict=True) if rows else ((), (), (), ())
    times = np.append(0, np.cumsum(widths)) * TICK
    share = camera_off_centre(times[:-1], np.radians(pans), linears, angulars, float(times[-1]))
    assert share == (
        pytest.approx(aside / driven) if driven else pytest.approx(math.nan, nan_ok=True)
    )


@given(
    st.lists(st.tuples(TICKS, st.none() | st.integers(0, 40)), max_size=6),
    st.lists(st.tuples(TICKS, st.integers(0, 40)), max_size=10),
)
def test_motion_to_photon(inputs, frames) -> None:
    answers = [math.nan if late is None else float(at + late) for at, late in inputs]
    found = motion_to_photon(
        [float(at) for at, _ in inputs],
        answers,
        [float(taken) for taken, _ in frames],
        [float(taken + late) for taken, late in frames],
    )
    for (at, _), answer, delay in zip(inputs, answers, found, strict=True):
        shown = [taken + late for taken, late in frames if taken >= answer and taken + late >= at]
        assert delay == pytest.approx(min(shown) - at if shown else math.nan, nan_ok=True)


@given(
    st.lists(st.tuples(st.integers(0, 15), st.booleans()), min_size=1, max_size=20),
    st.integers(1, 20),
)
def test_product_limit(times, tau: int) -> None:
    def left(moment: int) -> Fraction:
        share = Fraction(1)
        for at in sorted({time for time, seen in times if seen and time <= moment}):
            risk = sum(time >= at for time, _ in times)
            share *= 1 - Fraction(sum(time == at and seen for time, seen in times), risk)
        return share

    curve = kaplan_meier(*zip(*times, strict=True))
    assert [curve.at(moment) for moment in range(16)] == pytest.approx(
        [float(left(moment)) for moment in range(16)]
    )
    half = [moment for moment in range(16) if left(moment) <= Fraction(1, 2)]
    assert curve.median.value == (min(half) if half else math.inf)
    area = sum(left(moment) for moment in range(tau))
    assert curve.restricted_mean(tau).value == pytest.approx(float(area))
