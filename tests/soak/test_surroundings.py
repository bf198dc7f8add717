"""What else happens to a hub: crowds, deaths, half-open connections, clocks, full disks."""

from __future__ import annotations

import collections
import contextlib
import os
import resource
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from tests.misbehaving import bad_connections
from tests.soak.good_traffic import GoodTraffic
from tests.soak.rig import AT, SENT, Rig
from tests.support.waiting import until
from tests.support.wall_clock import WallClock

CROWD_S = float(os.environ.get("RUNE_SOAK_CROWD_S", "60"))
_CROWD = 200
_DEATHS = 15
_YEAR_S = 365 * 24 * 3600
GAP_MS = 100.0
"""Between two messages of 500 Hz when the clock steps: twice 50 ms, the machine being shared."""


def _raw(path: str, socket_type: bytes) -> socket.socket:
    made = bad_connections.connect(path)
    made.sendall(bad_connections.greeting() + bad_connections.ready(socket_type))
    return made


def test_central_lets_go_of_unfinished_connections_by_itself_and_bears_silent_ones(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    """Their other ends never say anything any more, nor close.

    Those that were made in full cost a descriptor each until their system is gone.
    """
    rig = make_rig(transport="ipc")
    traffic = GoodTraffic(rig, quiet_s=1.0, timed=False)
    with contextlib.ExitStack() as held:
        for number in range(100):
            path = rig.central.paths[number % 5]
            made = held.enter_context(bad_connections.connect(path))
            made.sendall(bad_connections.greeting()[: 10 + number % 55])
        silent = 80
        for kind, place in ((b"SUB", 2), (b"SUB", 4), (b"PUB", 1), (b"PUB", 3)):
            for _ in range(silent // 4):
                made = held.enter_context(_raw(rig.central.paths[place], kind))
                if kind == b"SUB":
                    made.sendall(b"\0\1\1")  # everything, and it never reads
        connected = traffic.before.descriptors + silent + 50
        until(lambda: rig.central.vitals().descriptors > connected, 10.0, "they never connected")
        started = time.monotonic()
        until(
            lambda: rig.central.vitals().descriptors <= traffic.before.descriptors + silent + 2,
            20.0,
            lambda: f"{rig.central.vitals().descriptors} descriptors are still open",
        )
        took_s = time.monotonic() - started
    until(
        lambda: rig.central.vitals().descriptors <= traffic.before.descriptors + 2,
        5.0,
        lambda: f"{rig.central.vitals().descriptors} descriptors are still open",
    )
    bars = traffic.finish()
    tell(let_go_after_s=round(took_s, 2), **traffic.figures, bars=bars)


@pytest.mark.soak
@pytest.mark.timeout(120)
def test_module_is_killed_in_the_middle_of_large_frames(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    rig = make_rig(transport="ipc")
    traffic = GoodTraffic(rig, quiet_s=1.0, timed=False)
    viewer = rig.module("viewer", subscribe=["S_Picture"])
    for _ in range(_DEATHS):
        before = len(viewer.received("S_Picture"))
        dying = rig.module("dying", publish=[("S_Picture", 30.0, 3_900_000)])
        until(lambda before=before: len(viewer.received("S_Picture")) > before + 2, 20.0)
        dying.kill()
        del rig.modules["dying"]
    # And one that stops within a frame without ending its connection at once.
    raw = _raw(rig.central.paths[1], b"PUB")
    raw.sendall(b"\2" + struct.pack(">Q", 3_000_000) + bytes(1_000_000))
    raw.close()
    dropped = rig.dropped()
    complaints = viewer.finish()["complaints"]
    bars = traffic.finish()
    del bars["memory back"]  # what is kept for frames of 4 MB is not meant
    bars["no half frame came through"] = not complaints.get("malformed frame")
    tell(deaths=_DEATHS, dropped=dropped, complaints=complaints, **traffic.figures, bars=bars)


def _crowd(
    make_rig: Callable[..., Rig], tell: Callable[..., None], at_once: int, seconds: float
) -> None:
    rig = make_rig(transport="both")
    traffic = GoodTraffic(rig, quiet_s=seconds / 12.0, timed=at_once == _CROWD)
    crowds = [
        rig.other(
            "tests.misbehaving.passers_by",
            rig.endpoints[part % 2],
            str(at_once // 4),
            str(seconds),
            str(part),
        )
        for part in range(4)
    ]
    until(lambda: all(c.process.poll() is not None for c in crowds), seconds + 60.0)
    came = [crowd.line() for crowd in crowds]
    until(lambda: len(rig.listing().peers) <= 5, 10.0, "some passers-by are never forgotten")
    bars = traffic.finish()
    bars["they were connected"] = all(each.get("were connected", 0) for each in came)
    bars["no fault in a passer-by"] = not any(each.get("faults") for each in came)
    tell(came=came, **traffic.figures, bars=bars)


@pytest.mark.soak
@pytest.mark.timeout(300)
def test_two_hundred_clients_come_and_go(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _crowd(make_rig, tell, _CROWD, CROWD_S)


@pytest.mark.soak
def test_twenty_clients_come_and_go(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _crowd(make_rig, tell, 20, 2.0)


def _spent_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


@pytest.mark.parametrize(
    ("bursts", "burst"),
    [(4, 100), pytest.param(100, 500, marks=[pytest.mark.soak, pytest.mark.timeout(120)])],
)
def test_central_serves_who_is_connected_when_descriptors_run_out(
    make_rig: Callable[..., Rig], tell: Callable[..., None], bursts: int, burst: int
) -> None:
    """More connections than it may open, and they stay: others can follow when they end."""
    rig = make_rig(transport="both")
    traffic = GoodTraffic(rig, quiet_s=1.0, timed=False)
    central = psutil.Process(rig.central.pid)
    limit = traffic.before.descriptors + 3 * burst
    central.rlimit(resource.RLIMIT_NOFILE, (limit, limit))
    places = [*map(str, rig.central.ports), *rig.central.paths]
    # The oldest are let go: this process may not open as many as it likes either.
    held: collections.deque[socket.socket] = collections.deque(maxlen=2 * burst)
    for number in range(bursts * burst):
        if len(held) == held.maxlen:
            held.popleft().close()
        with contextlib.suppress(BlockingIOError):  # too many wait there already
            held.append(bad_connections.connect(places[number % len(places)]))
        if number % burst == 0:
            # Soon, and not only when handshakes time out after 3 s.
            until(lambda: central.num_fds() < limit * 0.6, 2.0, "it takes too many")
    spent, started = _spent_s(central), time.monotonic()
    until(lambda: time.monotonic() > started + 1.0, 10.0)
    spent, took = _spent_s(central) - spent, time.monotonic() - started
    while held:
        held.pop().close()
    settled = traffic.before.descriptors + 10
    until(lambda: central.num_fds() < settled, 10.0, "it does not let go of them")
    dropped = rig.dropped()
    peers = len(rig.listing().peers)
    bars = traffic.finish()
    bars["newcomers connect again"] = peers == 5
    bars["it does not spin"] = spent / took < 0.4
    bars["it says why"] = dropped.get("too many connections", 0) > 0
    tell(limit=limit, cpu=round(spent / took, 3), dropped=dropped, **traffic.figures, bars=bars)


@pytest.mark.soak
@pytest.mark.parametrize("timed", [False, True])
def test_steps_of_the_wall_clock_are_not_noticed(
    make_rig: Callable[..., Rig],
    tell: Callable[..., None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    *,
    timed: bool,
) -> None:
    clock = WallClock(tmp_path)
    environment, step = {**os.environ, **clock.environment}, clock.step
    step(_YEAR_S)
    told = subprocess.run(
        [sys.executable, "-c", "import time; print(time.time())"],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert float(told.stdout) > time.time() + _YEAR_S - 60.0, "the clock is not moved"
    step(0)
    for name in ("LD_PRELOAD", "RUNE_WALL_CLOCK"):
        monkeypatch.setenv(name, environment[name])
    rig = make_rig(transport="ipc")
    traffic = GoodTraffic(rig, quiet_s=1.0, timed=timed)
    subscriber = rig.modules["subscriber"]
    for name in ("LD_PRELOAD", "RUNE_WALL_CLOCK"):
        monkeypatch.delenv(name)
    started_ns = time.monotonic_ns()
    for seconds in (3600, -3600, _YEAR_S, -_YEAR_S, 0):
        step(seconds)
        before = len(subscriber.rows())
        until(lambda before=before: len(subscriber.rows()) > before + 400, 20.0)
    bars = traffic.finish()
    rows = subscriber.received("S_Event")
    arrivals = rows[rows[:, SENT] > started_ns][:, AT]
    gap_ms = float((arrivals[1:] - arrivals[:-1]).max() / 1e6)
    bars["no gap"] = gap_ms <= GAP_MS or not timed
    tell(longest_gap_ms=round(gap_ms, 1), **traffic.figures, bars=bars)


def test_full_disk_for_the_log_stops_nothing(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    """Not a byte more can be written to the file that standard error is."""
    rig = make_rig(transport="ipc")
    nothing = (0, 0)
    psutil.Process(rig.central.pid).rlimit(resource.RLIMIT_FSIZE, nothing)
    traffic = GoodTraffic(rig, quiet_s=1.0, timed=False)
    attack = bad_connections.Attack(rig.central.paths, 3)
    for _ in range(300):
        attack.one()
    attack.close()
    dropped = rig.dropped()
    written = rig.central.log.stat().st_size
    bars = traffic.finish()
    bars["there was something to log"] = sum(dropped.values()) > 0
    bars["nothing could be written"] = written == 0
    tell(dropped=dropped, **traffic.figures, bars=bars)
