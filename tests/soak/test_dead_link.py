"""A link that is dead without anybody closing it, and its healing."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

from hub.errors import HubError
from hub.ipc.client import Client
from tests.soak import vocabulary as v
from tests.soak.module_process import Row
from tests.soak.rig import AT, KIND, SENT, ModuleProcess, Rig, Rows, Started
from tests.support.waiting import until

DEAD_S = float(os.environ.get("RUNE_SOAK_DEAD_S", "20"))
SEEN_S = 2.1
"""Lost is seen in 2 s, and a tenth for the looking."""
FRESH_S = 0.5
STALE_S = v.COMMAND.lifespan_s + 0.02
"""An age does not hold the time of the fastest way, hence a little more than the lifespan."""
_NAMES = ("S_Event", "S_Command")


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """How a link is cut and healed; each returns when it has happened [ns]."""

    cut: Callable[[], int]
    heal: Callable[[], int]


class Names:
    """Who is connected at central, as a client sees it that is on central's side of the link."""

    def __init__(self, endpoint: str) -> None:
        self._client = Client("watcher", endpoint)
        self._client.wait_connected(10.0)

    def now(self) -> set[str]:
        """The names."""
        return {peer.name for peer in self._client.directory.listing(5.0).peers}

    def close(self) -> None:
        """End."""
        self._client.close()


def _after_s(rows: Rows, kind: Row, since_ns: int) -> float:
    """When this first happened after `since_ns` [s]; infinite if it did not."""
    chosen = rows[(rows[:, KIND] == kind) & (rows[:, AT] > since_ns)]
    return float((chosen[0, AT] - since_ns) / 1e9) if len(chosen) else float("inf")


def _fresh(subscriber: ModuleProcess, name: str, since_ns: int) -> float:
    """When the first of these that was sent after `since_ns` was handled, after it [s]."""

    def rows() -> Rows:
        received = subscriber.received(name)
        return received[received[:, SENT] > since_ns]

    until(lambda: len(rows()), 30.0, f"no {name} after the link was healed")
    return float((rows()[0, AT] - since_ns) / 1e9)


def _wait(seconds: float) -> None:
    end = time.monotonic() + seconds
    until(lambda: time.monotonic() > end, seconds + 5.0)


def _modules(rig: Rig, publisher_at: str, subscriber_at: str) -> tuple[ModuleProcess, ...]:
    publisher = rig.module(
        "publisher",
        endpoint=publisher_at,
        publish=[("S_Event", 100.0, 200), ("S_Command", 50.0, 20), ("S_Picture", 15.0, 57_600)],
    )
    subscriber = rig.module("subscriber", endpoint=subscriber_at, subscribe=list(v.BROADCASTS))
    rig.wait_flowing(subscriber, *_NAMES)
    return publisher, subscriber


def _oldest_s(subscriber: ModuleProcess) -> float:
    commands = subscriber.received("S_Command")
    return float((commands[:, AT] - commands[:, SENT]).max() / 1e9)


def _check_dead(
    rig: Rig,
    link: Link,
    modules: tuple[ModuleProcess, ...],
    tell: Callable[..., None],
    *,
    dead_s: float,
    behind: set[str],
    names: Names | None,
) -> None:
    """Cut, wait, heal; `behind` are the modules that are cut off from central."""
    publisher, subscriber = modules
    cut_ns = link.cut()
    gone_s = float("nan")
    if names is not None and dead_s > SEEN_S:
        until(lambda: not names.now() & behind, 10.0, "central never saw that they are gone")
        gone_s = (time.monotonic_ns() - cut_ns) / 1e9
    _wait(dead_s - (time.monotonic_ns() - cut_ns) / 1e9)
    seen_s = {
        module.plan.name: _after_s(module.rows(), Row.LOST, cut_ns)
        for module in modules
        if module.plan.name in behind
    }
    healed_ns = link.heal()
    fresh_s = {name: round(_fresh(subscriber, name, healed_ns), 3) for name in _NAMES}
    _wait(2.0)
    rig.wait_drained(publisher, subscriber)
    summary = subscriber.finish()
    oldest_s = _oldest_s(subscriber)
    commands = subscriber.received("S_Command")
    stale = int(((commands[:, AT] - commands[:, SENT]) / 1e9 > STALE_S).sum())
    bars = {
        "no fault in a module": not (summary["faults"] or publisher.summary["faults"]),
        "fresh data at once": all(each <= FRESH_S for each in fresh_s.values()),
        "no stale command was handled": stale == 0,
        "no fault in central": "Traceback" not in rig.central.log.read_text(),
    }
    if dead_s > SEEN_S:
        bars["modules saw it in 2 s"] = max(seen_s.values()) <= SEEN_S
        bars["central saw it in 2 s"] = not gone_s > SEEN_S
    tell(
        dead_s=dead_s,
        behind=sorted(behind),
        modules_saw_after_s={name: round(each, 2) for name, each in seen_s.items()},
        central_saw_after_s=round(gone_s, 2),
        fresh_after_s=fresh_s,
        oldest_command_s=round(oldest_s, 3),
        stale_commands=stale,
        complaints=summary["complaints"],
        bars=bars,
    )


class Relayed:
    """A rig with a relay at 127.0.0.2."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        ports = rig.central.ports
        self.endpoint = f"tcp://127.0.0.2:{ports[0]}"
        self.relay: Started = rig.other(
            "tests.misbehaving.black_hole", "127.0.0.2", *map(str, ports)
        )
        self.relay.line()
        self.link = Link(cut=lambda: self._say("dark"), heal=lambda: self._say("light"))

    def _say(self, word: str) -> int:
        assert self.relay.process.stdin is not None
        self.relay.process.stdin.write(f"{word}\n".encode())
        self.relay.process.stdin.flush()
        return int(self.relay.line()[word])


_BEHIND = [{"publisher"}, {"subscriber"}, {"publisher", "subscriber"}]


def _check_relayed(
    make_rig: Callable[..., Rig], tell: Callable[..., None], behind: set[str], dead_s: float
) -> None:
    relayed = Relayed(make_rig())
    direct = relayed.rig.endpoints[0]
    places = [
        relayed.endpoint if name in behind else direct for name in ("publisher", "subscriber")
    ]
    modules = _modules(relayed.rig, *places)
    with contextlib.closing(Names(direct)) as names:
        _check_dead(
            relayed.rig, relayed.link, modules, tell, dead_s=dead_s, behind=behind, names=names
        )


@pytest.mark.soak
@pytest.mark.timeout(120)
@pytest.mark.parametrize("behind", _BEHIND, ids="-".join)
@pytest.mark.parametrize("dead_s", [0.8, 4.0, DEAD_S])
def test_black_hole_between_modules_and_central(
    make_rig: Callable[..., Rig], tell: Callable[..., None], behind: set[str], dead_s: float
) -> None:
    _check_relayed(make_rig, tell, behind, dead_s)


@pytest.mark.soak
@pytest.mark.timeout(120)
def test_commands_that_were_held_up_are_stale_for_a_newcomer_too(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    """It has nothing yet to compare their age with."""
    relayed = Relayed(make_rig())
    rig = relayed.rig
    publisher, early = _modules(rig, relayed.endpoint, rig.endpoints[0])
    relayed.link.cut()
    newcomer = rig.module("newcomer", subscribe=["S_Command"])
    until(lambda: len(newcomer.rows(Row.CONNECTED)), 10.0)
    _wait(0.3)
    relayed.link.heal()
    rig.wait_flowing(newcomer, "S_Command")
    rig.wait_drained(publisher, early, newcomer)
    ages = {}
    for module in (early, newcomer):
        module.finish()
        commands = module.received("S_Command")
        ages[module.plan.name] = round(_oldest_s(module), 3)
    tell(
        oldest_command_s=ages,
        first_ages_of_newcomer_s=[
            round(float(row[AT] - row[SENT]) / 1e9, 3) for row in commands[:40:5]
        ],
        bars={f"nothing stale at {name}": age <= STALE_S for name, age in ages.items()},
    )


@pytest.fixture
def namespace() -> Iterator[str]:
    """A network namespace of its own, with its loopback up."""
    name = f"rune-{os.getpid()}"
    if shutil.which("ip") is None:
        pytest.skip("no `ip` here")
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True, check=False)
    if made.returncode:
        pytest.skip(f"no network namespaces here: {made.stderr.strip()}")
    _set_loopback(name, "up")
    yield name
    subprocess.run(["ip", "netns", "delete", name], check=True)


def _set_loopback(namespace: str, state: str) -> int:
    command = ["ip", "netns", "exec", namespace, "ip", "link", "set", "lo", state]
    subprocess.run(command, check=True)
    return time.monotonic_ns()


@pytest.mark.soak
@pytest.mark.timeout(120)
@pytest.mark.parametrize("dead_s", [0.8, 4.0, DEAD_S])
def test_network_interface_goes_down_and_up(
    make_rig: Callable[..., Rig], tell: Callable[..., None], namespace: str, dead_s: float
) -> None:
    rig = make_rig(prefix=["ip", "netns", "exec", namespace])
    modules = _modules(rig, "", "")
    link = Link(
        cut=lambda: _set_loopback(namespace, "down"), heal=lambda: _set_loopback(namespace, "up")
    )
    with contextlib.suppress(HubError):
        _check_dead(
            rig,
            link,
            modules,
            tell,
            dead_s=dead_s,
            behind={"publisher", "subscriber"},
            names=None,
        )
