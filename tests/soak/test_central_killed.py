"""`kill -9` of central under load and a new one at the same endpoint at once, again and again."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from hub.errors import HubError
from hub.ipc.client import Client
from tests.soak import vocabulary as v
from tests.soak.module_process import Row
from tests.soak.rig import AT, KIND, NUMBER, SENT, ModuleProcess, Rig
from tests.support.waiting import until

ROUNDS = int(os.environ.get("RUNE_SOAK_ROUNDS", "50"))
FLOWS_MS = 300.0
"""Data is received again so soon after central listens."""
REGISTERED_MS = 1000.0
"""Every module is defined, subscribed and handling again."""
ENDED_S = 3.0
"""A query that was under way has ended with an error."""
HANDLED_AGE_S = v.COMMAND.lifespan_s + 0.02
"""An age does not hold the time of the fastest way, hence a little more than the lifespan."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Round:
    """Of one round, from when the new central listened [ms]."""

    flows_ms: float
    commands_ms: float
    registered_ms: float


def _load(rig: Rig) -> tuple[ModuleProcess, ...]:
    publisher = rig.module(
        "publisher",
        publish=[("S_Event", 500.0, 200), ("S_Command", 100.0, 20), ("S_Picture", 30.0, 57_600)],
    )
    subscriber = rig.module("subscriber", subscribe=list(v.BROADCASTS))
    # Slower than it is asked: queries are always under way.
    responder = rig.module("responder", answer_s=0.06)
    asker = rig.module("asker", ask_hz=15.0)
    rig.wait_flowing(subscriber, *v.BROADCASTS)
    until(lambda: len(asker.rows(Row.ANSWERED)), 20.0, "no query was answered")
    return publisher, subscriber, responder, asker


def _registered_ns(rig: Rig, name: str) -> int:
    """When a client of our own first sees all modules with all they need at the new central."""
    client = Client(name, rig.endpoints[0])
    try:
        client.wait_connected(10.0)
        defined = {*v.BROADCASTS, v.ASK.name, v.ANSWER.name}

        def complete() -> bool:
            try:
                listing = client.directory.listing(5.0)
            except HubError:
                return False
            handles = {peer.name: peer.handles for peer in listing.peers}
            return (
                {entry.name for entry in listing.definitions} >= defined
                and handles.keys() >= {"publisher", "subscriber", "responder", "asker"}
                and handles["responder"] == v.ASK.name
            )

        until(complete, 15.0, "the modules did not come back")
        return time.monotonic_ns()
    finally:
        client.close()


def _first_ms(subscriber: ModuleProcess, name: str, since_ns: int) -> float:
    """When the first of these that was sent since then was received, after it [ms]."""

    def fresh() -> np.ndarray:
        rows = subscriber.received(name)
        return rows[rows[:, SENT] >= since_ns]

    until(lambda: len(fresh()), 15.0, f"no {name} flows again")
    return float((fresh()[0, AT] - since_ns) / 1e6)


def _kill_and_restart(rig: Rig, subscriber: ModuleProcess, number: int) -> Round:
    rig.central.kill()
    if number % 5 == 4:  # and once more, while the modules are only coming back
        rig.start_central().kill()
    since = rig.start_central().listening_ns
    registered_ns = _registered_ns(rig, f"auditor {number}")
    return Round(
        flows_ms=_first_ms(subscriber, "S_Event", since),
        commands_ms=_first_ms(subscriber, "S_Command", since),
        registered_ms=(registered_ns - since) / 1e6,
    )


def _ended_s(asker: ModuleProcess, asked: int) -> np.ndarray:
    """How long the failed queries took; fails if one did not end exactly once [s]."""
    rows = asker.rows()
    ended = rows[(rows[:, KIND] == Row.ANSWERED) | (rows[:, KIND] == Row.FAILED)]
    numbers = sorted(ended[:, NUMBER].tolist())
    assert numbers == sorted(set(numbers)), "a query ended twice"
    # Those of the last moment may still be under way when the asker itself ends.
    assert len(numbers) >= asked - 10, "a query never ended"
    failed = ended[ended[:, KIND] == Row.FAILED]
    return (failed[:, AT] - failed[:, SENT]) / 1e9


def _check(
    make_rig: Callable[..., Rig],
    tell: Callable[..., None],
    transport: str,
    rounds: int,
    *,
    slack: float = 1.0,
) -> None:
    rig = make_rig(transport=transport)
    publisher, subscriber, _, asker = _load(rig)
    done: list[Round] = []
    for number in range(rounds):
        before = len(asker.rows(Row.ANSWERED))
        done.append(_kill_and_restart(rig, subscriber, number))
        until(
            lambda before=before: len(asker.rows(Row.ANSWERED)) > before + 3,
            20.0,
            "queries are not answered again",
        )
    rig.wait_drained(publisher, subscriber)
    summary = asker.finish()
    ended_s = _ended_s(asker, summary["asked"])
    commands = subscriber.received("S_Command")
    oldest_s = float((commands[:, AT] - commands[:, SENT]).max() / 1e9)
    for module in rig.modules.values():
        if not module.summary:
            module.finish()
    figures = {
        name: [round(value, 1) for value in np.percentile([getattr(r, name) for r in done],
                                                          (50, 90, 100))]
        for name in Round.__slots__
    }  # fmt: skip
    tell(
        rounds=len(done),
        transport=transport,
        median_90_max=figures,
        flows_late=sum(r.flows_ms > FLOWS_MS for r in done),
        registered_late=sum(r.registered_ms > REGISTERED_MS for r in done),
        oldest_command_s=round(oldest_s, 4),
        queries_failed=len(ended_s),
        slowest_failure_s=round(float(max(ended_s, default=0.0)), 3),
        failures=summary.get("failures"),
        bars={
            "no fault in a module": not any(
                module.summary["faults"] for module in rig.modules.values()
            ),
            "no command is handled after its lifespan": oldest_s <= HANDLED_AGE_S,
            "queries were under way when central died": len(ended_s) > 0,
            "they ended soon": max(ended_s, default=0.0) <= slack * ENDED_S,
            "all registered again in a second": all(
                r.registered_ms <= slack * REGISTERED_MS for r in done
            ),
            "data flows in 300 ms": all(r.flows_ms <= slack * FLOWS_MS for r in done),
            "central logged no traceback": "Traceback" not in rig.central.log.read_text(),
        },
    )


@pytest.mark.soak
@pytest.mark.timeout(900)
@pytest.mark.parametrize("transport", ["tcp", "ipc"])
def test_central_is_killed_and_started_again_under_load(
    make_rig: Callable[..., Rig], tell: Callable[..., None], transport: str
) -> None:
    _check(make_rig, tell, transport, ROUNDS)


@pytest.mark.soak
def test_central_is_killed_twice_under_load(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _check(make_rig, tell, "tcp", 2, slack=10.0)  # other tests run beside it
