"""Sleeps of this machine: each is found, and a busy machine is not taken for one that slept."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.transport.loop import Loop
from hub.machine_sleep import MachineSleep
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until


class Machine:
    """Two clocks, with any time between two readings."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance
        self.now, self.slept = 1e5, 0.0

    def clock(self) -> float:
        self._goes_on()
        return self.now

    def with_sleeps(self) -> float:
        self._goes_on()
        return self.now + self.slept

    def _goes_on(self) -> None:
        """Most of the time it is quick; now and then another process runs between."""
        self.now += self._chance.choice([1e-7, 1e-7, 1e-7, 0.004, 0.3])


@pytest.mark.parametrize("seed", range(20))
def test_each_sleep_is_found_and_nothing_else(seed: int) -> None:
    chance = random.Random(seed)
    machine = Machine(chance)
    sleep = MachineSleep(machine.clock, machine.with_sleeps)
    for _ in range(20):
        assert sleep.look() == 0.0
    for length in (1.0, 3600.0, 86_400.0, 2.0):
        for _ in range(20):
            assert sleep.look() == 0.0
        machine.slept += length
        found = next(filter(None, (sleep.look() for _ in range(50))))
        assert length - 0.7 <= found <= length + 1e-6


def test_a_system_without_the_second_clock_never_sleeps() -> None:
    machine = Machine(random.Random(1))
    sleep = MachineSleep(machine.clock, machine.clock)
    assert {sleep.look() for _ in range(100)} == {0.0}


class Sleepy(MachineSleep):
    """Reports `slept` once."""

    slept = 0.0

    def look(self) -> float:
        slept, self.slept = self.slept, 0.0
        return slept


@pytest.fixture
def endpoint(tmp_path: Path) -> Iterator[str]:
    with closing(Central([f"ipc://{tmp_path}/central"])) as running:
        yield running.endpoints[0]


def test_what_was_sent_before_a_sleep_is_older_by_it_and_does_not_count(endpoint: str) -> None:
    sleep = Sleepy()
    with (
        closing(Loop(sleep=sleep)) as loop,
        closing(Client("receiver", endpoint, loop=loop)) as receiver,
        closing(Client("sender", endpoint)) as sender,
    ):
        came: list[tuple[int, float]] = []
        woke: list[tuple[float, int]] = []

        def keep(number: Number, info: MessageInfo) -> None:
            came.append((number.value, info.age))

        receiver.when_slept(lambda time: woke.append((time, len(came))))
        for definition in (v.COMMAND, v.LOG):
            receiver.subscribe(definition, keep)

        def both() -> None:
            loop.listen(0.01)
            sender.listen(0.01)

        receiver.wait_subscribed(10.0)
        sender.wait_connected(10.0)
        for definition in (v.COMMAND, v.LOG):
            sender.publish(definition, Number(value=0))
        until(lambda: len(came) == 2, 10.0, meanwhile=both)
        came.clear()
        for definition in (v.COMMAND, v.LOG):
            sender.publish(definition, Number(value=1))
        sender.listen(0.0)
        sleep.slept = 1.0  # so short that the connection stays
        until(lambda: came, 10.0, meanwhile=lambda: loop.listen(0.01))
        assert [value for value, _ in came] == [1], "the command is older than its lifespan"
        assert came[0][1] >= 1.0
        assert woke == [(1.0, 0)], "the sleep is reported before anything is read"

        came.clear()
        during = receiver.loop.clock() + 0.5  # by a sender whose clock went on
        sender.publish(v.LOG, Number(value=3), measured=during)
        sender.listen(0.0)
        sleep.slept = 1.0
        until(lambda: came, 10.0, meanwhile=lambda: loop.listen(0.01))
        assert came[0][1] >= 0.5, "it was sent in the sleep, half a second before its end"
        sender.publish(v.COMMAND, Number(value=2))

        until(lambda: came[-1][0] == 2, 10.0, meanwhile=both)
        assert came[-1][1] < 1.0
        came.clear()
        sleep.slept = 3600.0
        until(lambda: len(woke) == 2, 10.0, meanwhile=lambda: loop.listen(0.01))
        receiver.wait_connected(10.0)
