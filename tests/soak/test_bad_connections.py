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
from tests.waiting import until

CONNECTIONS = int(os.environ.get("RUNE_SOAK_CONNECTIONS", "100000"))
AT_MOST_S = float(os.environ.get("RUNE_SOAK_ATTACK_S", "180"))


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


def test_thousand_bad_connections(make_rig: Callable[..., Rig], tell: Callable[..., None]) -> None:
    _attack(make_rig, tell, count=1000, at_most_s=5.0, timed=False)


@pytest.mark.soak
@pytest.mark.timeout(120)
def test_three_hundred_thousand_subscriptions_of_one_peer(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    rig = make_rig(transport="tcp")
    traffic = GoodTraffic(rig, quiet_s=5.0, timed=True)
    flood = bad_connections.greeting() + bad_connections.ready(b"SUB")
    most = traffic.before.memory_mb
    with bad_connections.connect(str(rig.central.ports[2])) as raw:
        raw.settimeout(30.0)
        raw.sendall(flood)
        sent = 0
        # Central hangs up on who does not answer its heartbeats for 5 s.
        with contextlib.suppress(ConnectionError):
            for sent in range(0, 300_000, 1000):
                numbers = range(sent, sent + 1000)
                raw.sendall(b"".join(b"\0\x20\1%031d" % number for number in numbers))
        most = max(most, rig.central.vitals().memory_mb)
    bars = traffic.finish()
    tell(sent=sent, peak_mb=most, **traffic.figures, bars=bars)
