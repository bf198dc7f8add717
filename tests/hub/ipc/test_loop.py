"""One loop for several centrals, timers and files; and the same within asyncio."""

from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.ipc.asyncio_pump import AsyncioPump
from hub.ipc.central import Central
from hub.ipc.client import Client
from hub.ipc.loop import Loop
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.waiting import until


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


def test_dispatch_serves_until_it_is_ended() -> None:
    loop = Loop()
    calls: list[str] = []
    loop.every(0.001, lambda: calls.append("every"), count=3)
    loop.after(0.002, lambda: calls.append("after"))
    cancelled = loop.every(0.001, lambda: calls.append("cancelled"))
    cancelled.cancel()
    loop.after(0.05, loop.end)
    loop.dispatch()
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


async def test_asyncio_program_gets_every_message_and_keeps_its_own_time(
    two: tuple[str, str],
) -> None:
    peer = Peer("peer", two[0]).connect()
    client = Client("asyncio", two[0])
    pump = AsyncioPump(client.loop)
    came: list[int] = []
    ticks = 0
    try:
        client.subscribe(v.LOG, lambda n, _: came.append(n.value))
        peer.call(lambda: peer.client.respond(v.ASK, v.ANSWER, lambda ask: ask))

        async def wait(done: object) -> None:
            async with asyncio.timeout(20.0):
                while not done():  # noqa: ASYNC110
                    await asyncio.sleep(0.001)

        await wait(lambda: client.connected and client._inlets.standing)

        def flood() -> None:
            for number in range(3000):
                peer.client.publish(v.LOG, Number(value=number))
                if number % 50 == 0:
                    peer.client.listen(0.001)

        thread = threading.Thread(target=lambda: peer.call(flood))
        thread.start()
        while thread.is_alive() or len(came) < 3000:
            await asyncio.sleep(0.001)
            ticks += 1
        thread.join()
        assert came == list(range(3000))
        assert ticks > 1
        answers: list[int] = []
        client.query_notify(
            v.ASK,
            Number(value=5),
            v.ANSWER,
            timeout=5.0,
            answered=lambda n, _: answers.append(n.value),
            failed=lambda _: answers.append(-1),
        )
        await wait(lambda: answers)
        assert answers == [5]
    finally:
        pump.close()
        client.close()
        peer.close()


async def test_fault_of_a_handler_is_told_to_asyncio_and_the_pump_goes_on() -> None:
    loop = Loop()
    faults: list[BaseException] = []
    asyncio.get_running_loop().set_exception_handler(
        lambda _, context: faults.append(context["exception"])
    )
    pump = AsyncioPump(loop)
    calls: list[int] = []
    loop.after(0.001, lambda: 1 // 0)
    loop.every(0.002, lambda: calls.append(1))
    async with asyncio.timeout(10.0):
        while len(calls) < 3:  # noqa: ASYNC110
            await asyncio.sleep(0.001)
    assert [type(fault) for fault in faults] == [ZeroDivisionError]
    pump.close()
    loop.close()


async def test_pump_serves_a_new_file_that_has_the_number_of_a_closed_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("hub.ipc.asyncio_pump._LONGEST_S", 60.0)  # nothing else wakes it
    loop, came = Loop(), asyncio.Event()
    ends = list(os.pipe())

    def read() -> None:
        os.read(ends[0], 1)
        came.set()

    def replace() -> None:
        before = tuple(ends)
        loop.unwatch(before[0])
        for end in before:
            os.close(end)
        ends[:] = os.pipe()
        assert ends[0] == before[0]
        loop.watch(ends[0], read)

    loop.watch(ends[0], read)
    pump = AsyncioPump(loop)
    try:
        for work in (lambda: None, replace):
            done = asyncio.Event()
            loop.post(work)
            loop.post(done.set)
            async with asyncio.timeout(5.0):
                await done.wait()
                came.clear()
                os.write(ends[1], b"x")
                await came.wait()
    finally:
        pump.close()
        loop.close()
        for end in ends:
            os.close(end)
