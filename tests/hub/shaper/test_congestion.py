"""How TCP decides how many packets may be on their way."""

from __future__ import annotations

import math
import statistics

import pytest

from hub.shaper.congestion import CongestionWindow
from hub.shaper.model import LinkDirection, LinkModel
from hub.shaper.profile import LinkProfile
from tests.hub.shaper.profiles import profile


def transfer(made: LinkProfile, size: int, seed: int = 1) -> float:
    """Time until so many bytes of one stream have arrived, sent at once [s]."""
    direction: LinkDirection[int] = LinkModel[int](made, seed).down
    for place in range(0, size, 1448):
        direction.send(0, place, min(1448, size - place), 0.0)
    last = 0.0
    while direction.due < math.inf:
        for delivery in direction.take(direction.due):
            last = delivery.time
    assert direction.counts.delivered == direction.counts.packets
    return last


def test_the_window_doubles_each_round_trip_and_then_grows_by_half_a_packet() -> None:
    window = CongestionWindow()
    for _ in range(10):
        window.answered(int(window.size), 2.0)
    assert window.size == 20.0
    window.showed_loss(0.0, 1.0)
    assert window.size == 14.0
    window.showed_loss(0.5, 1.1)  # of the same window
    assert window.size == 14.0
    window.answered(14, 0.9)  # sent before the loss showed
    assert window.size == 14.0
    for _ in range(14):
        window.answered(14, 2.0)
    assert window.size == pytest.approx(14.53, abs=0.02)
    window.timed_out()
    assert window.size == 1.0
    for _ in range(4):
        window.answered(int(window.size), 2.0)
    assert window.size == 5.0


def test_a_window_that_limits_nothing_does_not_grow_and_a_pause_shrinks_it() -> None:
    window = CongestionWindow()
    window.answered(1, 0.0)
    assert window.size == 10.0
    for _ in range(30):
        window.answered(int(window.size), 2.0)
    window.use(1.0, 0.5)
    window.use(1.4, 0.5)
    assert window.size == 10.0  # the first use came after an endless pause
    for _ in range(30):
        window.answered(int(window.size), 2.0)
    window.use(1.5, 0.5)
    assert window.size == 40.0


def test_a_long_transfer_needs_some_round_trips_to_be_fast() -> None:
    """139 packets: 10, 20, 40 and 69 of them, each a round trip after the others."""
    assert transfer(profile(delay=0.1, rate=1e9), 200_000) == pytest.approx(0.7, abs=0.01)


def test_losses_make_a_long_transfer_slow() -> None:
    """As over real TCP, where 200 kB took 4.3 s at 100 ms each way and a loss of 5 %."""
    took = sorted(transfer(profile(delay=0.1, loss=0.05, rate=1e7), 200_000, n) for n in range(20))
    assert 2.0 < took[10] < 8.0
    assert transfer(profile(delay=0.001, loss=0.05, rate=1e7), 200_000) < took[0]


def test_a_long_transfer_without_losses_fills_the_link() -> None:
    assert transfer(profile(delay=0.02, rate=1e6), 1_000_000) == pytest.approx(8.3, rel=0.05)


@pytest.mark.parametrize(("loss", "kernel_kbit"), [(0.01, 1340.0), (0.05, 430.0), (0.10, 280.0)])
def test_a_long_transfer_is_as_fast_as_that_of_a_kernel(loss: float, kernel_kbit: float) -> None:
    """CUBIC of Linux 6.18 over a link of 10 Mbit/s and 50 ms each way; docs/links.md has more."""
    made = profile(delay=0.05, loss=loss, rate=1e7)
    size = 3_000_000
    kbit = statistics.median(8e-3 * size / transfer(made, size, seed) for seed in range(5))
    assert 0.8 < kbit / kernel_kbit < 1.8
