"""A hundred thousand connections that are wrong in every way, and good traffic beside them."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable

import pytest

from tests.misbehaving import bad_connections
from tests.soak.good_traffic import GoodTraffic
from tests.soak.rig import Rig
from tests.support.waiting import until

CONNECTIONS = int(os.environ.get("RUNE_SOAK_CONNECTIONS", "100000"))
AT_MOST_S = float(os.environ.get("RUNE_SOAK_ATTACK_S", "180"))
FLOOD_MB = 25.0
"""What the subscriptions of a flood may take up until central has seen it."""
FLOOD_MS = 500.0
"""What the end of a flood may hold others up."""


def _addresses(rig: Rig) -> str:
    return ",".join([*map(str, rig.central.ports), *rig.central.paths])


def _attack(
    make_rig: Callable[..., Rig],
    tell: Callable[..., None],
    *,
    count: int,
    at_most_s: float,
    timed: bool,
) -> None:
    rig = make_rig(transport="both")
    traffic = GoodTraffic(rig, quiet_s=min(5.0, at_most_s / 5.0), timed=timed)
    attacker = rig.other(
        "tests.misbehaving.bad_connections", _addresses(rig), str(count), str(at_most_s), "1"
    )
    memory = [traffic.before.memory_mb]

    def look() -> None:
        if rig.central.process.poll() is None:
            memory.append(rig.central.vitals().memory_mb)
        time.sleep(0.2)

    until(lambda: attacker.process.poll() is not None, at_most_s + 60.0, meanwhile=look)
    made = attacker.line()
    dropped = rig.dropped()
    bars = traffic.finish()
    tell(attack=made, peak_mb=max(memory), dropped=dropped, **traffic.figures, bars=bars)


@pytest.mark.soak
@pytest.mark.timeout(400)
def test_hundred_thousand_bad_connections(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _attack(make_rig, tell, count=CONNECTIONS, at_most_s=AT_MOST_S, timed=True)


@pytest.mark.soak
def test_thousand_bad_connections(make_rig: Callable[..., Rig], tell: Callable[..., None]) -> None:
    _attack(make_rig, tell, count=1000, at_most_s=5.0, timed=False)


def _flood(
    make_rig: Callable[..., Rig],
    tell: Callable[..., None],
    *,
    transport: str,
    count: int,
    rounds: int,
    timed: bool,
) -> None:
    """A flood every other second: each costs the others some tens of milliseconds, once."""
    rig = make_rig(transport=transport)
    traffic = GoodTraffic(rig, quiet_s=3.0 if timed else 0.5, timed=timed)
    memory = [traffic.before.memory_mb]
    sent = []
    for _ in range(rounds):
        with bad_connections.subscriber(rig.central.paths[2]) as raw:
            sent.append(0)
            with contextlib.suppress(OSError):  # central hangs up
                for start in range(0, count, 500):
                    numbers = range(start, start + 500)
                    raw.sendall(b"".join(b"\0\x20\1%031d" % number for number in numbers))
                    sent[-1] = start + 500
            memory.append(rig.central.vitals().memory_mb)
        next_round = time.monotonic() + (2.0 if timed else 0.0)
        until(lambda end=next_round: time.monotonic() >= end, 10.0)
    dropped = rig.dropped()
    bars = traffic.finish()
    bars["central hangs up each time"] = dropped.get("flood of subscriptions", 0) >= rounds
    if timed:
        longest = max(each["during"]["max_ms"] for each in traffic.figures["latencies"].values())
        bars["good messages wait for a moment at most"] = longest < FLOOD_MS
    bars["central takes few of them in"] = max(memory) - memory[0] < FLOOD_MB
    tell(sent=sent, peak_mb=max(memory), dropped=dropped, **traffic.figures, bars=bars)


@pytest.mark.soak
@pytest.mark.timeout(120)
@pytest.mark.parametrize("transport", ["tcp", "ipc"])
def test_three_hundred_thousand_subscriptions_of_one_peer(
    make_rig: Callable[..., Rig], tell: Callable[..., None], transport: str
) -> None:
    _flood(make_rig, tell, transport=transport, count=300_000, rounds=5, timed=True)


@pytest.mark.soak
@pytest.mark.parametrize("transport", ["tcp", "ipc"])
def test_flood_of_subscriptions_is_ended_and_good_ones_are_not(
    make_rig: Callable[..., Rig], tell: Callable[..., None], transport: str
) -> None:
    _flood(make_rig, tell, transport=transport, count=300_000, rounds=1, timed=False)
