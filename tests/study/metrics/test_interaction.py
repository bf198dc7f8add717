"""Episodes, TE, neglect tolerance and fan-out, on numbers worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.errors import DataError
from rune_study.estimate import Estimate, unknown
from rune_study.metrics import fan_out as fo
from rune_study.metrics.effectiveness import (
    Signal,
    attended,
    driven,
    rate_of_progress,
    signal,
)
from rune_study.metrics.episodes import Episode, covered, episodes
from rune_study.metrics.neglect import neglects, threshold
from rune_study.metrics.trial_time import trial_time
from tests.support.cases import for_each

INF = math.inf


def spans(*ends: tuple[float, float]) -> tuple[Episode, ...]:
    return tuple(Episode(begin=begin, end=end, inputs=1) for begin, end in ends)


def working(*ends: tuple[float, float], until: float = 100.0) -> Signal:
    """TE of 1 within spans, 0 elsewhere, 10 times a second."""
    times = np.arange(round(until * 10) + 1) / 10
    values = np.zeros(times.shape)
    for begin, end in ends:
        values[(times >= begin - 1e-9) & (times < end - 1e-9)] = 1.0
    return Signal(times=times, values=values)


def found(episodes_of, rate: Signal, until: float = 100.0) -> list[tuple[float, bool]]:
    return [
        (pytest.approx(each.length), each.seen) for each in neglects(episodes_of, rate, until, 0.5)
    ]


def test_episodes_by_hand() -> None:
    made = episodes([30, 10, 10.5, 11, 14], [9, 13.5])
    assert [(each.begin, each.end, each.inputs) for each in made] == [
        (9, 11, 3),
        (13.5, 14.5, 1),
        (30, 30.5, 1),
    ]
    assert made[0].length == 2


@for_each(
    ("inputs", "chosen", "wanted"),
    [
        ([], [1.0], []),
        ([0, 1, 2.9, 5], [], [(0, 2.9), (5, 5.5)]),
        ([0, 2], [], [(0, 2)]),
        ([0.1, 2.1], [], [(0.1, 2.1)]),
        ([5], [2.9], [(5, 5.5)]),
        ([5], [3], [(3, 5.5)]),
        ([5], [3, 4, 5, 6], [(5, 5.5)]),
        ([11, 13.1], [11.2], [(11, 11.5), (11.5, 13.6)]),
        ([99.8], [], [(99.8, 100)]),
        ([7, 7], [], [(7, 7.5)]),
    ],
)
def test_ends_of_episodes(inputs, chosen, wanted) -> None:
    made = episodes(inputs, chosen, until=100)
    assert [(each.begin, pytest.approx(each.end)) for each in made] == wanted


@for_each(
    ("chosen", "held", "wanted"),
    [
        ([], [], [(10, 14)]),
        ([9, 12], [], [(9, 11), (12, 14)]),  # the input at the very choice comes after it
        ([12.4, 13.9], [], [(10, 12), (12.4, 13.5), (13.9, 14.5)]),
        ([12], [(11, 13)], [(10, 14)]),  # a key that is held is no return
        ([20], [], [(10, 14)]),
    ],
)
def test_a_choice_within_an_episode_can_split_it(chosen, held, wanted) -> None:
    inputs = [10, 11, 12, 13, 14]
    made = episodes(inputs, chosen, held=held, split_at_selections=True)
    assert [(each.begin, pytest.approx(each.end)) for each in made] == wanted
    (whole,) = episodes(inputs, chosen, held=held)
    assert whole.end == 14


def test_a_held_key_is_no_pause() -> None:
    inputs = [1.0, 1.3, 9.0, 14.0, 14.2]
    made = episodes(inputs, held=[(1.0, 9.0)])
    assert [(each.begin, each.end, each.inputs) for each in made] == [(1, 9, 3), (14, 14.5, 2)]
    # Two keys that are held one after the other leave the pause between them.
    made = episodes([1.0, 4.0, 9.0, 12.0], held=[(1.0, 4.0), (9.0, 12.0)])
    assert [(each.begin, each.end) for each in made] == [(1, 4), (9, 12)]


def test_a_key_that_is_held_all_the_time_is_one_episode_without_an_input() -> None:
    (whole,) = episodes([], held=[(0.0, 20.0)], until=20.0)
    assert (whole.begin, whole.end, whole.inputs) == (0.0, 20.0, 0)
    (whole,) = episodes([21.0, 21.02, 24.2], held=[(0.0, 21.0), (21.02, 24.2)], until=50.0)
    assert (whole.begin, whole.end, whole.inputs) == (0.0, 24.2, 3)


def test_times_are_finite() -> None:
    with pytest.raises(DataError, match="inputs: a time is not finite"):
        episodes([1, math.nan])


@given(st.lists(st.floats(0.0, 60.0), max_size=20), st.lists(st.floats(0.0, 60.0), max_size=5))
def test_episodes_are_apart_and_hold_all_inputs(inputs, chosen) -> None:
    made = episodes(inputs, chosen)
    assert sum(each.inputs for each in made) == len(inputs)
    ends = [end for each in made for end in (each.begin, each.end)]
    assert ends == sorted(ends)
    for each in inputs:
        assert any(span.begin <= each <= span.end for span in made)


@for_each(
    ("ends", "wanted"),
    [
        ([(0, 4), (2, 6), (10, 12), (99, 120)], 9),
        ([], 0),
        ([(-5, 1)], 1),
        ([(5, 5), (7, 6)], 0),
        ([(0, 100), (20, 30)], 100),
    ],
)
def test_what_overlaps_counts_once(ends, wanted: float) -> None:
    assert covered(ends, 0.0, 100.0) == wanted


def test_drops_that_are_seen_and_one_that_is_not() -> None:
    rate = working((0, 30), (34, 60), (70, 100))
    assert found(spans((5, 10), (33, 35), (65, 71)), rate) == [(20, True), (25, True), (29, False)]


@for_each(
    ("ends", "served", "until", "wanted"),
    [
        # A dip of 1 s does not count.
        ([(0, 30), (31, 60)], [(0, 10)], 100, (50, True)),
        # Down before he left.
        ([(0, 20)], [(18, 25)], 100, (0, True)),
        # He returned before the drop.
        ([(0, 40)], [(0, 10), (25, 30)], 50, (15, False)),
        # Down for 1 s, and he came; down for 0.2 s is rather chance.
        ([(0, 40)], [(0, 10), (41, 50)], 50, (30, True)),
        ([(0, 40)], [(0, 10), (40.2, 50)], 50, (30.2, False)),
        ([(0, 40)], [(0, 10), (40.5, 50)], 50, (30, True)),
        # The trial ended before 3 s were over, and nobody came.
        ([(0, 48)], [(0, 10)], 50, (40, False)),
        ([(0, 47)], [(0, 10)], 50, (37, True)),
        # A run of exactly 3 s lasts 3 s.
        ([(0, 30), (33, 60)], [(0, 10)], 100, (20, True)),
        # Between two samples.
        ([(0, 20)], [(18, 25.05)], 100, (0, True)),
        # The episode ends with the trial.
        ([(0, 100)], [(0, 100)], 100, (0, False)),
    ],
)
def test_edges_of_neglect(ends, served, until: float, wanted) -> None:
    assert found(spans(*served), working(*ends), until)[0] == wanted


def test_where_progress_is_not_known_the_time_is_censored() -> None:
    rate = working((0, 30))
    rate.values[200:250] = math.nan
    assert found(spans((5, 10)), rate) == [(10, False)]
    assert found(spans((5, 22)), rate) == [(0, False)]
    assert found(spans((5, 26)), rate) == [(4, True)]
    late = Signal(times=np.arange(20.0, 100.0), values=np.ones(80))
    assert found(spans((5, 10)), late) == [(0, False)]
    nothing = Signal(times=np.empty(0), values=np.empty(0))
    assert found(spans((5, 10)), nothing) == [(90, False)]


def test_threshold() -> None:
    rate = Signal(times=np.arange(10.0), values=np.array([9, 1, 2, 3, 9, 9, 9, 9, math.nan, 4]))
    assert threshold(rate, spans((1, 4))) == 1.0
    assert threshold(rate, spans((1, 4)), 0.25) == 0.5
    assert threshold(rate, spans((7.5, 9.5))) == 2.0
    assert math.isnan(threshold(rate, ()))
    assert math.isnan(threshold(rate, spans((8, 9))))
    still = Signal(times=np.arange(3.0), values=np.zeros(3))
    assert math.isnan(threshold(still, spans((0, 3))))


@given(
    st.lists(st.booleans(), min_size=1, max_size=60),
    st.lists(st.integers(0, 60), min_size=2, max_size=8, unique=True),
)
def test_a_neglect_ends_before_the_operator_returns(low, cuts) -> None:
    cuts = sorted(cuts)
    served = spans(*zip(cuts[::2], cuts[1::2], strict=False))
    rate = Signal(times=np.arange(float(len(low))), values=1.0 - np.array(low, float))
    made = neglects(served, rate, 60.0, 0.5)
    assert len(made) == len(served)
    for each, after in zip(made, [*(one.begin for one in served[1:]), 60.0], strict=True):
        assert 0.0 <= each.length <= max(0.0, after - each.begin)
        if each.seen and each.length > 0.0:
            assert low[round(each.begin + each.length)]


def test_rate_of_even_progress_is_its_slope() -> None:
    rate = rate_of_progress(signal([0, 10, 20], [0, 5, 5]), 20.0)
    assert len(rate.times) == 201
    at = dict(zip(rate.times.round(1).tolist(), rate.values.tolist(), strict=True))
    assert [at[time] for time in (0.0, 5.0, 9.5, 10.0, 10.5, 20.0)] == pytest.approx(
        [0.5, 0.5, 0.5, 0.25, 0.0, 0.0]
    )


def test_where_progress_is_silent_the_rate_is_not_known() -> None:
    rate = rate_of_progress(signal([0, 1, 2, 12, 13, 14], range(6)), 14.0, longest_gap=5.0)
    at = dict(zip(rate.times.round(1).tolist(), rate.values.tolist(), strict=True))
    assert at[1.0] == at[1.5] == at[12.5] == pytest.approx(1.0)
    assert all(math.isnan(at[time]) for time in (1.6, 7.0, 12.4))
    assert np.isnan(rate_of_progress(signal([], []), 3.0).values).all()
    with pytest.raises(DataError, match="above 0"):
        rate_of_progress(signal([0, 1], [0, 1]), 3.0, window=0.0)


def test_signals() -> None:
    assert signal([0, 0, 1], [5, 6, 7]).values.tolist() == [6, 7]
    assert signal([], []).times.size == 0
    for times, values in (([1, 0], [1, 2]), ([0], [1, 2]), ([math.nan], [1])):
        with pytest.raises(DataError, match="ascending"):
            signal(times, values)


def test_noise_of_a_robot_that_stands_is_no_way() -> None:
    assert driven([0, 0.01] * 500, [0] * 1000)[-1] == 0
    assert driven([0, 3, math.nan, 3], [0, 0, 1, 4]).tolist() == [0, 3, 3, 7]
    assert driven(np.arange(11) * 0.02, np.zeros(11))[-1] == pytest.approx(0.18)


def test_attended_samples() -> None:
    inside = attended(Signal(times=np.arange(5.0), values=np.zeros(5)), spans((1, 3), (4, 9)))
    assert inside.tolist() == [False, True, True, False, True]


@for_each(
    ("effort", "tolerance", "demand", "free", "robots"),
    [
        (10, 30, 0.25, 0.75, 4),
        (5, 5, 0.5, 0.5, 2),
        (4, 0, 1, 0, 1),
        (3, INF, 0, 1, INF),
        (INF, 3, 1, 0, 1),
        (0, 3, 0, 1, INF),
        (0, 0, math.nan, math.nan, math.nan),
        (INF, INF, math.nan, math.nan, math.nan),
        (math.nan, 3, math.nan, math.nan, math.nan),
        (0, INF, 0, 1, INF),
    ],
)
def test_demand_free_time_and_fan_out(effort, tolerance, demand, free, robots) -> None:
    made = (
        fo.attention_demand(effort, tolerance),
        fo.free_time(effort, tolerance),
        fo.fan_out(effort, tolerance),
    )
    assert made == pytest.approx((demand, free, robots), nan_ok=True)


def test_effort_from_others() -> None:
    assert fo.effort_from_free_time(30, 0.75) == pytest.approx(10)
    assert fo.effort_from_fan_out(30, 4) == pytest.approx(10)
    assert fo.effort_from_free_time(30, 0) == fo.effort_from_fan_out(30, 1) == INF
    with pytest.raises(DataError, match="negative"):
        fo.attention_demand(-1, 3)


@given(st.floats(0.001, 1e6), st.floats(0.001, 1e6), st.floats(0.001, 1e3))
def test_units_of_time_do_not_matter(effort: float, tolerance: float, factor: float) -> None:
    demand = fo.attention_demand(effort, tolerance)
    assert fo.attention_demand(factor * effort, factor * tolerance) == pytest.approx(demand)
    assert 0.0 <= demand <= 1.0
    assert fo.fan_out(effort, tolerance) >= 1.0
    assert fo.effort_from_fan_out(tolerance, 1.0 + tolerance / effort) == pytest.approx(effort)


def test_free_time_of_a_secondary_task() -> None:
    assert fo.free_time_of_secondary_task(45, 300, 100, 300).value == pytest.approx(0.45)
    more = fo.free_time_of_secondary_task(50, 100, 40, 100)
    assert (more.value, "above 1" in more.note) == (1.25, True)
    assert not fo.free_time_of_secondary_task(5, 10, 0, 10).known
    assert not fo.free_time_of_secondary_task(5, 10, 0, 0).known
    assert not fo.free_time_of_secondary_task(5, 10, 5, math.inf).known


def test_fan_out_has_the_interval_of_a_ratio() -> None:
    effort = Estimate(value=10, low=8, high=12, n=5)
    tolerance = Estimate(value=30, low=24, high=36, n=5, note="restricted to 60 s")
    made = fo.fan_out_estimate(effort, tolerance)
    factor = math.exp(0.2 * math.sqrt(2))
    assert (made.value, made.low, made.high) == pytest.approx((4, 1 + 3 / factor, 1 + 3 * factor))
    assert made.note == "restricted to 60 s"
    assert fo.fan_out_estimate(effort, Estimate(value=0.0)).value == 1
    assert fo.fan_out_estimate(unknown("nobody"), tolerance).why == "nobody"
    assert not fo.fan_out_estimate(Estimate(value=0.0), Estimate(value=0.0)).known


def test_active_robots_are_served_or_work() -> None:
    rate = working((0, 10), until=19.9)
    one = fo.TeamRobot(spans=spans((10, 15)), rate=rate, below=0.5)
    two = fo.TeamRobot(spans=(), rate=rate, below=math.nan)
    assert fo.active_robots([one]) == pytest.approx(0.75)
    assert fo.active_robots([one, one, two]) == pytest.approx(1.5)
    assert math.isnan(fo.active_robots([]))


def test_pauses_are_cut_out() -> None:
    time = trial_time(100, 200, [(150, 160), (120, 125), (124, 130), (190, 300), (0, 110)])
    assert time.length == 60
    at = [90, 105, 110, 119, 120, 127, 130, 155, 161, 189, 250]
    assert time.moments(at).tolist() == [0, 0, 0, 9, 10, 10, 10, 30, 31, 59, 60]
    kept = time.during(at)
    assert kept.tolist() == [False, False, True, True, False, False, True, False, True, True, False]
    assert trial_time(5, 5).length == 0
    for begin, end, pause in ((5, 4, (3, 3)), (0, 9, (3, 2)), (math.nan, 3, (3, 3))):
        with pytest.raises(DataError, match="before it begins"):
            trial_time(begin, end, [pause])


@given(
    st.lists(st.tuples(st.integers(-5, 50), st.integers(0, 20)), max_size=5),
    st.lists(st.integers(-10, 60), min_size=1),
)
def test_time_never_runs_back(pauses, at) -> None:
    time = trial_time(0, 45, [(begin, begin + length) for begin, length in pauses])
    moments = time.moments(sorted(at))
    assert (np.diff(moments) >= 0).all()
    assert ((moments >= 0) & (moments <= time.length)).all()
