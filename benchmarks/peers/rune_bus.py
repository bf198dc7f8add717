"""Our own bus, through its public interface alone."""

from __future__ import annotations

import itertools
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.peers.job import (
    HEAD,
    SAMPLE_FORMAT,
    Job,
    Sample,
    ask_for,
    counter,
    drive,
    sample,
    samples,
)
from benchmarks.peers.page import now
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.message_info import MessageInfo

_CONNECT_S = 10.0
_AT_ONCE = 100
"""Priming messages of several names sent together; a queue must hold them."""
_SERVE_NS = 100_000_000
"""How often a sender serves its connection in between [ns]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A message of a number of bytes; its first ones hold number and stamp."""

    length: int
    data: npt.NDArray[np.uint8]


def definitions(job: Job) -> list[MessageDefinition]:
    """The messages of a run, sent in turn."""
    kind, layout = (Sample, SAMPLE_FORMAT) if job.size == 48 else (Block, "{int,<ubyte:1>}")
    plane = getattr(Plane, job.options.get("plane", "STATE"))
    stem = "Sample" if job.size == 48 else "Block"
    return [
        MessageDefinition(
            name=f"Bench_{stem}_{number}", format=layout, type=kind, keep=Keep.ALL, plane=plane
        )
        for number in range(job.options.get("definitions", 1))
    ]


def published(job: Job) -> int:
    """How many of the messages are sent in turn; the others are only defined and subscribed to."""
    return job.options.get("published", job.options.get("definitions", 1))


def connected(name: str, job: Job) -> Client:
    client = Client(name, job.endpoint, near=job.options.get("near", True))
    client.wait_connected(_CONNECT_S)
    return client


def broker(job: Job) -> None:
    central = Central([job.endpoint])
    signal.pause()
    central.close()


def send(job: Job) -> None:
    page, client, messages = job.open(), connected("sender", job), definitions(job)
    client.define(*messages)
    client.wait_defined(_CONNECT_S)
    served = now()

    def pause(seconds: float) -> None:
        nonlocal served
        if now() - served > _SERVE_NS:
            client.listen(0.0)
            served = now()
        time.sleep(seconds)

    put = _sender(client, messages, job)
    drive(job, page, put, pause)
    while True:
        client.listen(0.5)


def _sender(client: Client, messages: list[MessageDefinition], job: Job) -> Callable[[int], None]:
    publish, only, size = client.publish, messages[0], job.size
    count = published(job)
    if size != 48:
        data = np.random.default_rng(1).integers(0, 256, size, dtype=np.uint8)

        def send_block(number: int) -> None:
            HEAD.pack_into(data, 0, number, now())
            publish(only, Block(length=size, data=data))

        return send_block
    values = samples(job)
    if count == 1:
        return lambda number: publish(only, values(number))
    primed = itertools.count()

    def send_in_turn(number: int) -> None:
        if number:
            publish(messages[number % count], values(number))
            return
        for index in itertools.islice(primed, min(count, _AT_ONCE)):
            publish(messages[index % count], values(0))

    return send_in_turn


def receive(job: Job) -> None:
    client, messages = connected(f"receiver{job.index}", job), definitions(job)
    take = counter(job)

    def sample_came(value: Sample, how: MessageInfo) -> None:
        del how
        take(value.number, value.stamp)

    def block_came(value: Block, how: MessageInfo) -> None:
        del how
        take(*HEAD.unpack_from(value.data))

    if "definitions" in job.options:
        missing = set(range(published(job)))
        for which, message in enumerate(messages):
            client.subscribe(message, _one_of_many(take, which, missing))
    else:
        client.subscribe(messages[0], sample_came if job.size == 48 else block_came)
    while True:
        client.listen(0.5)


def _one_of_many(
    take: Callable[[int, int], None], which: int, missing: set[int]
) -> Callable[[Sample, MessageInfo], None]:
    """A handler that is ready only after every message arrived once."""

    def came(value: Sample, how: MessageInfo) -> None:
        del how
        if value.number == 0:
            missing.discard(which)
        if value.number or not missing:
            take(value.number, value.stamp)

    return came


def ask(job: Job) -> None:
    page, client = job.open(), connected("asker", job)
    question, reply = _questions()

    def ask_one(number: int) -> int:
        answer = client.query_response(question, sample(number), reply, timeout=2.0)
        return answer.number

    ask_for(job, page, ask_one)


def answer(job: Job) -> None:
    client = connected("answerer", job)
    question, reply = _questions()
    client.respond(question, reply, lambda value: sample(value.number))
    while True:
        client.listen(0.5)


def _questions() -> tuple[MessageDefinition[Sample], MessageDefinition[Sample]]:
    question = MessageDefinition(name="Bench_Ask", format=SAMPLE_FORMAT, type=Sample)
    reply = MessageDefinition(name="Bench_Answer", format=SAMPLE_FORMAT, type=Sample)
    return question, reply


def _ignore(value: Sample, how: MessageInfo) -> None:
    del value, how


def crowd(job: Job) -> None:
    """Modules that are connected and have nothing to do."""
    page, count = job.open(), job.options["modules"]
    together = threading.Barrier(count)

    def live(number: int) -> None:
        name = f"idle_{os.getpid()}_{number}"
        client = connected(name, job)
        message = MessageDefinition(name=name, format=SAMPLE_FORMAT, type=Sample)
        client.subscribe(message, _ignore)
        client.wait_defined(_CONNECT_S)
        if together.wait() == 0:
            page.set_ready(job.index)
        while True:
            client.listen(0.5)

    for number in range(count):
        threading.Thread(target=live, args=(number,), daemon=True).start()
    signal.pause()
