"""The orders to the processes of one run, the plans by which they send, and what they send."""

from __future__ import annotations

import json
import os
import struct
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.peers.page import Page, now

PRIME = -1
"""The step of a plan that sends message 0, which tells subscribers that their way is open."""
_PRIME_S = 0.005
_WAIT_S = 20e-6
_STALL_NS = 500_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One run.

    Attributes:
        page: File of the shared page.
        endpoint: Where the broker listens, tcp:// or ipc://.
        size: Bytes of a message.
        subscribers: How many receive.
        seconds: How long is measured [s].
        window: Most messages under way to the slowest subscriber: no bus wins by dropping.
        hertz: Rate of a paced run [Hz]; 0 sends as fast as the window allows.
        index: Which subscriber a process is.
        options: What else the contender wants to know.
    """

    page: str
    endpoint: str
    size: int = 48
    subscribers: int = 1
    seconds: float = 0.5
    window: int = 200
    hertz: float = 0.0
    index: int = 0
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def port(self) -> int:
        return int(self.endpoint.rpartition(":")[2])

    def open(self) -> Page:
        return Page(Path(self.page))

    def to_json(self) -> str:
        return json.dumps(asdict(self))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """The typed message of 48 bytes."""

    number: int
    stamp: int
    x: float
    y: float
    theta: float
    speed: float


SAMPLE_FORMAT = "{ulong,long,double,double,double,double}"
"""Of `Sample`, for contenders that know formats; the others pack the same 48 bytes."""

HEAD = struct.Struct("<Qq")
_SAMPLE = struct.Struct("<Qqdddd")


def sample(number: int) -> Sample:
    return Sample(number=number, stamp=now(), x=1.0, y=2.0, theta=0.5, speed=0.3)


def samples(job: Job) -> Callable[[int], Sample]:
    """Where a run's typed values come from.

    At full speed one value is sent again and again with another number, because making values is
    the application's work and not the bus's; a paced run makes each one, with its stamp.
    """
    if job.hertz:
        return sample
    value, renumber = sample(0), object.__setattr__

    def again(number: int) -> Sample:
        renumber(value, "number", number)
        return value

    return again


def sample_bytes(value: Sample) -> bytes:
    """The typed work of a contender whose messages are bytes: encode."""
    return _SAMPLE.pack(value.number, value.stamp, value.x, value.y, value.theta, value.speed)


def sample_from(raw: bytes) -> Sample:
    """The typed work of a contender whose messages are bytes: decode."""
    number, stamp, x, y, theta, speed = _SAMPLE.unpack(raw)
    return Sample(number=number, stamp=stamp, x=x, y=y, theta=theta, speed=speed)


def maker(job: Job) -> Callable[[int], bytes]:
    """Makes message bytes from a number: typed at 48 bytes, else a head and random bytes."""
    if job.size == 48:
        values = samples(job)
        return lambda number: sample_bytes(values(number))
    rest, pack = os.urandom(job.size - HEAD.size), HEAD.pack
    return lambda number: pack(number, now()) + rest


def reader(size: int, take: Callable[[int, int], None]) -> Callable[[bytes], None]:
    """Calls `take` with number and stamp of message bytes: typed at 48 bytes, else the head's."""
    if size != 48:
        return lambda raw: take(*HEAD.unpack_from(raw))

    def read(raw: bytes) -> None:
        value = sample_from(raw)
        take(value.number, value.stamp)

    return read


def counter(job: Job) -> Callable[[int, int], None]:
    """What a subscriber calls with number and stamp of every message."""
    return job.open().counter(job.index, timed=job.hertz > 0)


def plan(job: Job, page: Page) -> Iterator[tuple[int, float]]:
    """What to do, step after step: a number of messages to send, or PRIME, then a pause [s]."""
    while not page.ready(job.subscribers):
        yield PRIME, _PRIME_S
    page.begin()
    sent, stalls = yield from (_paced if job.hertz else _flowing)(job, page)
    page.end(sent, stalls)


def _paced(job: Job, page: Page) -> Generator[tuple[int, float], None, tuple[int, int]]:
    start, period = now(), 1e9 / job.hertz
    count = int(job.seconds * job.hertz)
    for index in range(count):
        left = start + index * period - now()
        if left > 0:
            yield 0, left * 1e-9
        yield 1, 0.0
    return count, (yield from _all_received(job, page, count))


def _flowing(job: Job, page: Page) -> Generator[tuple[int, float], None, tuple[int, int]]:
    """As fast as the slowest subscriber lets us, with never more than the window under way."""
    step = max(1, job.window // 12)
    sent = floor = stalls = 0
    end = now() + int(job.seconds * 1e9)
    while now() < end:
        yield step, 0.0
        sent += step
        waiting = now()
        while sent + step - max(floor, page.slowest(job.subscribers)) > job.window:
            yield 0, _WAIT_S
            if now() - waiting > _STALL_NS:  # what is still missing was lost
                floor, stalls = sent, stalls + 1
    return sent, stalls + (yield from _all_received(job, page, sent))


def _all_received(job: Job, page: Page, sent: int) -> Generator[tuple[int, float], None, int]:
    """Wait for the last message; 1 if it does not come."""
    waiting = now()
    while page.slowest(job.subscribers) < sent:
        yield 0, _WAIT_S
        if now() - waiting > _STALL_NS:
            return 1
    return 0


def drive(
    job: Job,
    page: Page,
    send: Callable[[int], object],
    pause: Callable[[float], None] = time.sleep,
) -> None:
    """Carry out the plan; priming messages have number 0, the measured ones count from 1."""
    sent = 0
    for count, seconds in plan(job, page):
        if count == PRIME:
            send(0)
        else:
            for number in range(sent + 1, sent + count + 1):
                send(number)
            sent += count
        if seconds:
            pause(seconds)


def ask_for(job: Job, page: Page, ask: Callable[[int], int]) -> None:
    """Ask again and again; `ask` gets a number and returns the number in the answer.

    Before the bus answers, `ask` may raise or return something else.
    """
    deadline = time.monotonic() + 10.0
    while not _answered(ask):
        if time.monotonic() > deadline:
            text = "the bus does not answer"
            raise TimeoutError(text)
        time.sleep(0.01)
    page.begin()
    end, number = now() + int(job.seconds * 1e9), 0
    while now() < end:
        number += 1
        asked = now()
        answer = ask(number)
        page.note(now() - asked)
        if answer != number:
            text = f"the answer to {number} was {answer}"
            raise ValueError(text)
    page.end(number, 0)


def _answered(ask: Callable[[int], int]) -> bool:
    try:
        return ask(7) == 7
    except Exception:  # noqa: BLE001 - any error of a bus that does not answer yet
        return False
