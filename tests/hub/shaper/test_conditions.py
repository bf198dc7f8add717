"""The state of a link over time: what profiles promise, measured over long times."""

from __future__ import annotations

import itertools
import math
import statistics

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.shaper.conditions import DirectionConditions, spaced
from hub.shaper.profile import BurstsSpec, EpisodesSpec, load_profile, shipped_profiles
from tests.hub.shaper.profiles import profile
from tests.support.cases import for_each

SEEDS = st.integers(0, 2**32 - 1)


@for_each(("delay", "jitter"), [(0.25, 0.0707), (0.03, 0.0141), (0.01, 0.0035), (0.01, 0.02)])
def test_delays_have_the_mean_and_the_quantiles_of_their_logarithm(
    delay: float, jitter: float
) -> None:
    conditions = DirectionConditions(profile(delay=delay, jitter=jitter), 7, up=True)
    delays = sorted(conditions.delay(each * 0.5) for each in range(20_000))
    assert statistics.fmean(delays) == pytest.approx(delay, rel=0.03)
    assert statistics.stdev(delays) == pytest.approx(jitter, rel=0.12)
    sigma = math.sqrt(math.log1p((jitter / delay) ** 2))
    for share, z in ((0.05, -1.645), (0.5, 0.0), (0.95, 1.645)):
        expected = delay * math.exp(sigma * z - sigma**2 / 2.0)
        assert delays[int(share * len(delays))] == pytest.approx(expected, rel=0.04)
    assert delays[0] > 0.0


@for_each(("loss", "burst"), [(0.001, 1.0), (0.02, 3.0), (0.05, 4.0), (0.3, 10.0), (0.9, 12.0)])
def test_losses_have_their_part_of_the_time_and_their_mean_length(
    loss: float, burst: float
) -> None:
    made = profile(loss=loss, burst=burst, rate=1e6)
    conditions = DirectionConditions(made, 3, up=False)
    slot = made.down.slot
    lost = [conditions.lost((each + 0.5) * slot) for each in range(400_000)]
    runs = [len(list(group)) for bad, group in itertools.groupby(lost) if bad]
    error = 5.0 * math.sqrt(2.0 * burst * loss / len(lost))
    assert statistics.fmean(lost) == pytest.approx(loss, abs=error)
    assert statistics.fmean(runs) == pytest.approx(burst, rel=0.1)


@given(SEEDS)
@settings(max_examples=20)
def test_dropouts_come_about_once_a_minute_for_2_to_10_s(seed: int) -> None:
    spec = load_profile("dropouts").blackouts
    episodes = spaced(spec, seed, "blackout")
    assert episodes is not None
    edges = [0.0]
    while edges[-1] < 3600.0:
        edges.append(episodes.next_edge(edges[-1]))
    begins, ends = edges[1::2], edges[2::2]
    lengths = [end - begin for begin, end in zip(begins, ends, strict=False)]
    gaps = [begin - end for begin, end in zip(begins[1:], ends, strict=False)]
    assert all(2.0 <= each <= 10.0 for each in lengths)
    assert all(44.0 <= each <= 64.0 for each in gaps)
    assert begins[0] <= 64.0
    assert 52 <= len(lengths) <= 68
    for begin, end in zip(begins, ends, strict=False):
        assert episodes.at(begin) and episodes.at((begin + end) / 2.0)  # noqa: PT018 - one thought
        assert not episodes.at(end)


def test_both_directions_are_gone_in_a_blackout_together() -> None:
    made = profile(blackouts=EpisodesSpec(gap=(1.0, 3.0), length=(0.5, 2.0)))
    up, down = (DirectionConditions(made, 5, up=each) for each in (True, False))
    times = [each * 0.01 for each in range(10_000)]
    assert [up.lost(each) for each in times] == [down.lost(each) for each in times]
    assert 0.2 < statistics.fmean(map(up.blackout, times)) < 0.6


@given(SEEDS, st.lists(st.floats(0.0, 600.0), max_size=30))
@settings(max_examples=50)
def test_a_seed_fixes_everything_in_whatever_order_it_is_asked(
    seed: int, times: list[float]
) -> None:
    for name in shipped_profiles():
        made = load_profile(name)
        one, other = (DirectionConditions(made, seed, up=True) for _ in range(2))
        forward = {each: (one.delay(each), one.lost(each)) for each in times}
        backward = {each: (other.delay(each), other.lost(each)) for each in reversed(times)}
        assert forward == backward


def test_seeds_and_directions_differ() -> None:
    made = profile(delay=0.1, jitter=0.02)
    times = [each * 0.3 for each in range(100)]
    seen = {
        tuple(map(DirectionConditions(made, seed, up=up).delay, times))
        for seed in range(5)
        for up in (True, False)
    }
    assert len(seen) == 10


def test_known_numbers_of_a_seed_stay() -> None:
    """Recordings of studies name a seed: it must mean the same in every version."""
    made = load_profile("rubble")
    conditions = DirectionConditions(made, 7, up=True)
    assert conditions.delay(1.0) == pytest.approx(KNOWN_DELAY, abs=1e-9)
    lost = [each for each in range(2000) if conditions.lost(each * 0.02)]
    assert lost[:5] == KNOWN_LOSSES


KNOWN_DELAY = 0.2777621048913526
KNOWN_LOSSES = [278, 279, 592, 593, 594]


@given(SEEDS, st.floats(0.0, 300.0), st.integers(1, 100_000))
@settings(max_examples=200)
def test_a_burst_carries_more_and_no_bit_is_sent_twice(seed: int, time: float, size: int) -> None:
    bursts = BurstsSpec(gap=(1.0, 30.0), length=(1.0, 1.0), rate=3e6)
    conditions = DirectionConditions(profile(rate=9600.0, bursts=bursts), seed, up=True)
    middle = conditions.sent(time, size)
    assert time + 8.0 * size / 3e6 <= middle + 1e-9 <= time + 8.0 * size / 9600.0 + 1e-8
    assert conditions.sent(middle, size) == pytest.approx(conditions.sent(time, 2 * size))


def test_bursts_of_drc_carry_nearly_all() -> None:
    conditions = DirectionConditions(load_profile("drc"), 1, up=False)
    assert conditions.sent(0.0, 100_000_000) < 120.0  # 23 h at 9.6 kbit/s
