"""One loop for several centrals, timers and files."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.transport.loop import Loop
from hub.ipc.transport.timers import Timers
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until


@pytest.fixture
def two(tmp_path: Path) -> Iterator[tuple[str, str]]:
    """Endpoints of two centrals."""
    centrals = [Central([f"ipc://{tmp_path}/{name}"]) for name in "ab"]
    yield centrals[0].endpoints[0], centrals[1].endpoints[0]
    for central in centrals:
        central.close()


def test_one_loop_serves_clients_of_several_centrals(two: tuple[str, str]) -> None:
    loop = Loop()
    first, second = (Client("me", endpoint, loop=loop) for endpoint in two)
    came: list[tuple[str, int]] = []
    try:
        for client, name in ((first, "first"), (second, "second")):
            client.wait_connected(5.0)
            client.subscribe(v.LOG, lambda n, _, name=name: came.append((name, n.value)))
            client.wait_subscribed(5.0)
        first.publish(v.LOG, Number(value=1))
        second.publish(v.LOG, Number(value=2))
        until(lambda: len(came) == 2, 5.0, meanwhile=lambda: loop.listen(0.01))
        assert sorted(came) == [("first", 1), ("second", 2)]
        # A handler of one may use the other: that is how a bridge is made.
        first.subscribe(v.STREAM, lambda n, _: second.publish(v.STREAM, n))
        second.subscribe(v.STREAM, lambda n, _: came.append(("bridged", n.value)))
        first.wait_subscribed(5.0)
        second.wait_subscribed(5.0)
        first.publish(v.STREAM, Number(value=3))
        until(lambda: ("bridged", 3) in came, 5.0, meanwhile=lambda: loop.listen(0.01))
    finally:
        first.close()
        second.close()
        loop.close()


def test_timers_are_served_as_often_as_they_want() -> None:
    loop = Loop()
    calls: list[str] = []
    loop.every(0.001, lambda: calls.append("every"), count=3)
    loop.after(0.002, lambda: calls.append("after"))
    cancelled = loop.every(0.001, lambda: calls.append("cancelled"))
    cancelled.cancel()
    ended: list[bool] = []
    loop.after(0.05, lambda: ended.append(True))
    until(lambda: ended, 5.0, meanwhile=lambda: loop.listen(0.01))
    assert sorted(calls) == ["after", "every", "every", "every"]
    loop.close()


def test_loop_of_many_files_serves_each() -> None:
    loop = Loop()
    pipes = [os.pipe() for _ in range(20)]
    read: list[int] = []
    try:
        for number, (reading, _) in enumerate(pipes):
            loop.watch(reading, lambda n=number, f=reading: read.append(n) or os.read(f, 1))
        for _, writing in pipes:
            os.write(writing, b"x")
        until(lambda: len(read) == 20, 5.0, meanwhile=lambda: loop.listen(0.01))
        assert sorted(read) == list(range(20))
    finally:
        loop.close()
        for pipe in pipes:
            for file in pipe:
                os.close(file)


def test_an_alarm_rings_once_at_each_time_that_its_owner_sets() -> None:
    now = 0.0
    timers, rings = Timers(), list[float]()
    alarm = timers.alarm(lambda: rings.append(now))
    for step, due in enumerate([None, 3.0, 5.0, None, None, None, None, 8.0, None]):
        now = float(step)
        if due is not None:
            alarm.due = due  # the second time is later than the first one, which is gone
        timers.run(now)
    assert rings == [5.0, 8.0]
    assert timers.due(99.0) == math.inf
