"""NATS: its server, and its asyncio client."""

from __future__ import annotations

import asyncio
import os
import sys
from pathlib import Path

import nats
import nats.aio.client
import nats.aio.msg

from benchmarks.peers.job import (
    PRIME,
    Job,
    counter,
    maker,
    plan,
    reader,
    sample,
    sample_bytes,
    sample_from,
)
from benchmarks.peers.page import now

_SUBJECT, _ASK = "bench.t", "bench.ask"
_PENDING = 64 << 20


def broker(job: Job) -> None:
    server = Path(sys.executable).with_name("nats-server")
    os.execv(server, [str(server), "-a", "127.0.0.1", "-p", str(job.port)])


async def _connection(job: Job) -> nats.aio.client.Client:
    return await nats.connect(f"nats://127.0.0.1:{job.port}", pending_size=_PENDING)


def send(job: Job) -> None:
    asyncio.run(_send(job))


async def _send(job: Job) -> None:
    page, connection, make = job.open(), await _connection(job), maker(job)
    sent = 0
    for count, seconds in plan(job, page):
        if count == PRIME:
            await connection.publish(_SUBJECT, make(0))
        else:
            for number in range(sent + 1, sent + count + 1):
                await connection.publish(_SUBJECT, make(number))
            sent += count
        await asyncio.sleep(seconds)


def receive(job: Job) -> None:
    asyncio.run(_receive(job))


async def _receive(job: Job) -> None:
    read, connection = reader(job.size, counter(job)), await _connection(job)

    async def came(message: nats.aio.msg.Msg) -> None:
        read(message.data)

    await connection.subscribe(
        _SUBJECT, cb=came, pending_msgs_limit=1 << 20, pending_bytes_limit=1 << 30
    )
    await asyncio.Event().wait()


def _sample(number: int) -> bytes:
    return sample_bytes(sample(number))


def ask(job: Job) -> None:
    asyncio.run(_ask(job))


async def _ask(job: Job) -> None:
    page, connection = job.open(), await _connection(job)
    for _ in range(1000):
        try:
            await connection.request(_ASK, _sample(1), timeout=1.0)
            break
        except nats.errors.Error:
            await asyncio.sleep(0.01)
    page.begin()
    end, number = now() + int(job.seconds * 1e9), 0
    while now() < end:
        number += 1
        asked = now()
        answer = sample_from((await connection.request(_ASK, _sample(number), timeout=2.0)).data)
        page.note(now() - asked)
        if answer.number != number:
            text = f"the answer to {number} was {answer.number}"
            raise ValueError(text)
    page.end(number, 0)


def answer(job: Job) -> None:
    asyncio.run(_answer(job))


async def _answer(job: Job) -> None:
    connection = await _connection(job)

    async def came(message: nats.aio.msg.Msg) -> None:
        await message.respond(_sample(sample_from(message.data).number))

    await connection.subscribe(_ASK, cb=came)
    await asyncio.Event().wait()
