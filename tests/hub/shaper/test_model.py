"""A link that carries streams of TCP: order, rate, losses, and the queue."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.shaper.conditions import DirectionConditions
from hub.shaper.model import HEADERS, Delivery, LinkDirection, LinkModel
from hub.shaper.profile import EpisodesSpec, LinkProfile, load_profile, shipped_profiles
from tests.hub.shaper.profiles import profile
from tests.support.cases import for_each

Sent = tuple[float, int, int]
"""Time [s], stream, size [bytes]."""


def carried(made: LinkProfile, sent: Sequence[Sent], seed: int = 1) -> list[Delivery[int]]:
    """What comes out of direction up; the content is the place in `sent`."""
    direction: LinkDirection[int] = LinkModel[int](made, seed).up
    out: list[Delivery[int]] = []
    for place, (time, stream, size) in enumerate(sent):
        out += direction.take(time)
        direction.send(stream, place, size, time)
    while direction.due < math.inf:
        out += direction.take(direction.due)
    assert direction.counts.delivered == direction.counts.packets == len(sent)
    return out


_SENT = st.lists(
    st.tuples(st.floats(0.0, 0.5), st.integers(0, 3), st.integers(0, 20_000)), max_size=60
)


@given(_SENT, st.integers(0, 999), st.sampled_from(shipped_profiles()))
@settings(max_examples=150)
def test_all_arrive_once_in_the_order_of_their_stream_and_none_before_its_time(
    steps: list[Sent], seed: int, name: str
) -> None:
    made, time, sent = load_profile(name), 0.0, []
    for pause, stream, size in steps:
        time += pause
        sent.append((time, stream, size))
    out = carried(made, sent, seed)
    assert sorted(each.content for each in out) == list(range(len(sent)))
    times = [each.time for each in out]
    assert times == sorted(times)
    for stream in range(4):
        places = [each.content for each in out if each.stream == stream]
        assert places == sorted(places)
    fastest = made.bursts.rate if made.bursts else made.up.rate
    for each in out:
        began, _, size = sent[each.content]
        assert each.time >= began + 8.0 * (size + HEADERS) / fastest - 1e-9
    assert out == carried(made, sent, seed)


def test_streams_share_one_rate() -> None:
    sent = [(0.0, each % 5, 1448) for each in range(100)]
    out = carried(profile(rate=1.2e6, delay=0.1), sent)
    assert out[-1].time == pytest.approx(0.1 + 100 * 1500 * 8 / 1.2e6)
    assert [each.content for each in out[:50]] == list(range(50))


def test_a_lost_packet_holds_up_its_own_stream_only() -> None:
    made, slow = profile(delay=0.1, rate=1e7, loss=0.1, burst=1.0), 0
    sent = [(each * 0.04, each % 2, 100) for each in range(4000)]
    out = carried(made, sent)
    late = [each for each in out if each.time - sent[each.content][0] > 0.15]
    for each in late:
        neighbour = each.content + 1
        slow += any(other.content == neighbour and other.time < each.time for other in out[:4000])
    assert len(late) > 100
    assert slow > len(late) / 2


def _first_lost(made: LinkProfile, seed: int = 1) -> float:
    conditions = DirectionConditions(made, seed, up=True)
    time = 0.0
    while not (conditions.lost(time) and conditions.lost(time + 0.0001)):
        time += 0.0001
    return time + 0.0001


def test_a_lost_packet_that_is_followed_by_others_comes_a_round_trip_later() -> None:
    made = profile(delay=0.1, rate=1e8, loss=0.001, burst=8.0)
    lost = _first_lost(made)
    later = lost + 0.05
    first, second = carried(made, [(lost - 1e-5, 0, 10), (later, 0, 10)])
    assert first.time == second.time == pytest.approx(later + 0.3, abs=1e-3)


def test_a_lost_packet_that_nothing_follows_waits_for_the_time_out() -> None:
    made = profile(delay=0.1, rate=1e8, loss=0.001, burst=8.0)
    lost = _first_lost(made)
    (only,) = carried(made, [(lost - 1e-5, 0, 10)])
    assert only.time == pytest.approx(lost + 0.2 + 0.2 + 0.1, abs=1e-3)


def test_time_outs_double_in_a_blackout() -> None:
    made = profile(delay=0.1, blackouts=EpisodesSpec(gap=(60.0, 60.0), length=(12.0, 12.0)))
    begin = _first_lost(made)
    (only,) = carried(made, [(begin, 0, 10)])
    # Sent again after 0.4 s, 0.8 s, 1.6 s, 3.2 s and 6.4 s more.
    assert only.time == pytest.approx(begin + 0.4 + 0.8 + 1.6 + 3.2 + 6.4 + 0.1, abs=0.01)


def test_a_full_queue_says_when_it_has_room() -> None:
    direction: LinkDirection[int] = LinkModel[int](profile(rate=8000.0, queue=2000), 1).up
    assert direction.room_at(0.0) == 0.0
    for each in range(3):
        direction.send(0, each, 1000 - HEADERS, 0.0)
    assert direction.waiting(0.0) == 3000
    assert direction.room_at(0.0) == pytest.approx(2.0)
    assert direction.waiting(1.5) == 2000
    assert direction.room_at(2.5) == 2.5
    assert direction.waiting(10.0) == 0


def test_what_is_forgotten_does_not_come() -> None:
    direction: LinkDirection[int] = LinkModel[int](profile(delay=0.1), 1).up
    direction.send(1, 1, 10, 0.0)
    direction.send(2, 2, 10, 0.0)
    direction.forget(1)
    assert [each.content for each in direction.take(1.0)] == [2]
    assert direction.due == math.inf


@for_each(
    ("name", "least", "most"),
    [
        ("rubble", 0.5, 1.0),
        ("threshold", 0.25, 0.32),
        ("wifi-edge", 0.06, 0.1),
        ("lan", 0.001, 0.0011),
    ],
)
def test_small_answers_take_the_round_trip_and_a_little_more(
    name: str, least: float, most: float
) -> None:
    """One request after the other, of 32 bytes, as a game of ping-pong over one stream."""
    made, time, trips = load_profile(name), 0.0, []
    model: LinkModel[int] = LinkModel(made, 2)
    for _ in range(1000):
        began = time
        for direction in (model.up, model.down):
            direction.send(0, 0, 32, time)
            out: list[Delivery[int]] = []
            while not out:
                time = direction.due
                out = direction.take(time)
        trips.append(time - began)
    assert least <= statistics.fmean(trips) <= most
