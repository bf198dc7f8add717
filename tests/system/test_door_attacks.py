"""A hundred thousand wrong inputs to a door in one run, while others use it and drive the robot."""

from __future__ import annotations

import json
import os
import sys
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.control import CONTROL_STATE
from hub.gcm.navigation import GROUND_TRUTH, NAVIGATION_STATUS, ROBOT_STATE
from hub.ipc.client import Client
from tests.soak.rig import Started
from tests.support.foxglove_panel import Panels
from tests.support.waiting import until
from tests.system.door_attack import (
    SERVED_S,
    Costs,
    Served,
    TurningOperator,
    attack,
    driven,
    turned,
)
from tests.system.fleet_site import Site
from tests.system.harness import HubProcess, Observer, expect_stop

INPUTS = int(os.environ.get("RUNE_SOAK_INPUTS", "100000"))
RATE = 2500.0
"""Inputs a second."""
AT_MOST_S = 300.0


def rune_hub(log: Path, *words: str) -> Started:
    """A command of `rune-hub` whose log goes to a file."""
    command = [sys.executable, "-m", "hub", *words, "--json", "--stop-with-stdin"]
    return Started(command, log)


def attacker(name: str, folder: Path, *words: object) -> Started:
    """A program of `tests.misbehaving`."""
    command = [sys.executable, "-m", f"tests.misbehaving.{name}", *map(str, words)]
    return Started(command, folder / f"{name}.log")


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize("held", [True, False], ids=["held", "free"])
def test_hundred_thousand_bad_frames_of_panels(
    start_hub: Callable[..., HubProcess], stack: ExitStack, tmp_path: Path, *, held: bool
) -> None:
    hub = start_hub(modules=("driver", "navigation"))
    log = tmp_path / "door.log"
    door = rune_hub(log, "serve", "foxglove", "--hub", hub.endpoint, "--port", "0", "--drive")
    stack.callback(door.end)
    address = door.line()["address"]
    observer = stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH, CONTROL_STATE)))
    panels = stack.enter_context(closing(Panels(address)))
    panels.show("/odom")
    panels.newest("/odom")
    operator = stack.enter_context(ExitStack())
    alice = operator.enter_context(closing(TurningOperator(hub.endpoint))) if held else None
    served = Served(lambda: len(panels.payloads["/odom"]), panels.ask_parameters)

    def serve() -> None:
        if alice is not None:
            alice.client.listen(0.0)
        observer.client.listen(0.0)
        panels.pump(0.005)
        if panels.parameters:
            panels.parameters.clear()
            served.answered()
        served.look()

    panels.teleop()
    if held:  # so the door has asked for control once, and has its sockets for that
        panels.twist(0.3)
    until(lambda: served.answers > 20 and (panels.said or not held), 20.0, meanwhile=serve)
    observer.history.clear()
    costs = Costs(door.pid, log, hub.log)
    bad = attacker("bad_panel", tmp_path, address, INPUTS, RATE, 1, int(not held))
    stack.callback(bad.end)
    done = attack(bad, serve, AT_MOST_S)
    _check(done, served, observer, costs, serve)
    assert door.process.poll() is None
    operator.close()
    _wait_free(observer)
    _drives(panels, observer)


def _check(
    done: dict[str, Any],
    served: Served,
    observer: Observer,
    costs: Costs,
    serve: Callable[[], object],
) -> None:
    """Say what the attack cost; nothing drove, and the good client was served."""
    figures = {"gap_s": served.gap_s, "answers": served.answers, "slowest_s": served.slowest_s}
    sys.stderr.write(f"{done}\n{figures | costs.figures(serve)}\n")
    assert done["done"] == INPUTS
    assert len(observer.history) > 100
    assert driven(observer) == []
    assert turned(observer)
    assert max(served.gap_s, served.slowest_s) < SERVED_S
    costs.check()


def _wait_free(observer: Observer) -> None:
    states = observer.seen[CONTROL_STATE.name]
    observer.wait(lambda: states[-1][1].owner == 0, 10.0, "control is not free")


def _drives(panels: Panels, observer: Observer) -> None:
    """The panel that was there drives, and its silence stops the robot."""

    def moves() -> bool:
        panels.twist(0.3)
        observer.client.listen(0.02)
        return observer.truth.linear > 0.02

    panels.wait(moves, why="the panel does not drive any more;")
    expect_stop(observer)


class MirrorProcess:
    """`rune-hub fleet mirror`.

    Attributes:
        endpoints: Of the robots that it shows, by name.
        events: Number of what it said, by kind, and why robots went.
    """

    def __init__(self, place: str, log: Path) -> None:
        words = [
            "fleet",
            "mirror",
            "--fleet",
            "rune/lab",
            "--connect",
            place,
            "--as",
            "operate:ann",
        ]
        self.started = rune_hub(log, *words)
        self.endpoints: dict[str, str] = {}
        self.events: Counter[str] = Counter()
        # A console reads all that it says; a full pipe would stop it.
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.started.process.stdout is not None
        for line in self.started.process.stdout:
            said = json.loads(line)
            why = said.get("why", "") if said["event"] == "gone" else ""
            self.events[f"{said['event']} {why}".strip()] += 1
            if said["event"] == "robot":
                self.endpoints[said["robot"]] = said["endpoint"]

    def close(self) -> None:
        self.started.end()
        self._reader.join(5.0)


class Victim:
    """A client of the rogue's local hub: it has the mirror follow and ask what is wrong."""

    def __init__(self, endpoint: str) -> None:
        self.client = Client("victim", endpoint)
        self.ends: Counter[str] = Counter()
        for each in (CONTROL_STATE, ROBOT_STATE, NAVIGATION_STATUS):
            self.client.subscribe(each, lambda *_: self._end("heard"))
        self.client.every(0.05, self._ask)

    def _ask(self) -> None:
        if self.client.connected:
            self.client.last_notify(
                CONTROL_STATE,
                timeout=1.0,
                answered=lambda *_: self._end("answered"),
                failed=lambda error: self._end(type(error).__name__),
            )

    def _end(self, how: str) -> None:
        self.ends[how] += 1


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize("side", ["fleet", "console"])
def test_hundred_thousand_wrong_inputs_to_a_mirror(
    stack: ExitStack, tmp_path: Path, side: str
) -> None:
    site = stack.enter_context(closing(Site(tmp_path)))
    log = tmp_path / "mirror.log"
    words = (site.place, "rune/lab", "rogue", INPUTS if side == "fleet" else 0, RATE, 1)
    bad = rogue = attacker("rogue_robot", tmp_path, *words)
    stack.callback(rogue.end)
    assert rogue.line()
    mirror = stack.enter_context(closing(MirrorProcess(site.place, log)))
    until(lambda: {"rover", "rogue"} <= mirror.endpoints.keys(), 30.0)
    victim = Victim(mirror.endpoints["rogue"])
    stack.callback(victim.client.close)
    client = stack.enter_context(closing(Client("console", mirror.endpoints["rover"])))
    came: list[object] = []
    client.subscribe(GROUND_TRUTH, lambda *came_now: came.append(came_now))
    client.wait_connected(20.0)
    operator = stack.enter_context(ExitStack())
    alice = operator.enter_context(closing(TurningOperator(site.hub.endpoint)))
    unanswered: Counter[str] = Counter()

    def ask() -> None:
        client.last_notify(
            ROBOT_DESCRIPTION,
            timeout=SERVED_S,
            answered=lambda *_: served.answered(),
            failed=lambda error: unanswered.update([type(error).__name__]),
        )

    served = Served(lambda: len(came), ask)

    def serve() -> None:
        for each in (alice.client, site.observer.client, victim.client, client):
            each.listen(0.0)
        served.look()

    until(lambda: served.answers > 20 and victim.ends["answered"], 30.0, meanwhile=serve)
    site.observer.history.clear()
    costs = Costs(mirror.started.pid, log, site.hub.log)
    if side == "fleet":
        _begin(rogue)
    else:
        bad = attacker("bad_console", tmp_path, mirror.endpoints["rover"], INPUTS, RATE, 1)
        stack.callback(bad.end)
    done = attack(bad, serve, AT_MOST_S)
    sys.stderr.write(f"{dict(mirror.events)} {dict(victim.ends)} {dict(unanswered)}\n")
    _check(done, served, site.observer, costs, serve)
    assert mirror.started.process.poll() is None
    assert not unanswered
    operator.close()
    _wait_free(site.observer)
    with closing(TurningOperator(mirror.endpoints["rover"])) as ann:
        turns = lambda: ann.client.listen(0.01) or site.observer.truth.angular > 0.1  # noqa: E731
        site.observer.wait(turns, 20.0, "the console does not drive any more")
    site.observer.wait(lambda: site.observer.truth.commanded_angular == 0.0, 5.0)


def _begin(rogue: Started) -> None:
    assert rogue.process.stdin is not None
    rogue.process.stdin.write(b"\n")
    rogue.process.stdin.flush()
