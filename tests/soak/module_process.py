"""A module in a process of its own: it sends, receives, asks, answers, and writes all of it down.

python -m tests.soak.module_process PLAN, a JSON object; see `Plan`. What happens is appended to
the file `record` in rows of eight int64 (see `COLUMNS`); at SIGTERM a summary goes to standard
output as one JSON line.
"""

from __future__ import annotations

import collections
import enum
import json
import os
import signal
import struct
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hub.errors import QueryError
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from tests.soak import vocabulary as v
from tests.soak.vocabulary import Sample

COLUMNS = ("kind", "at_ns", "message", "publisher", "sequence", "missed", "number", "sent_ns")
_ROW = struct.Struct("<8q")
_LARGEST = (1 << 63) - 1
_FLUSH_S = 0.02
_TICK_S = 0.002
_LONGEST_BURST = 50
_ASK_TIMEOUT_S = 30.0


class Row(enum.IntEnum):
    """What a row of the record tells; `sent_ns` and `number` are those of the sample or query."""

    RECEIVED = 0
    ANSWERED = 1
    FAILED = 2
    CONNECTED = 3
    LOST = 4
    HANDLED = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What the module does.

    Attributes:
        name: Its name.
        endpoint: Where central is.
        record: Where its rows go.
        publish: Message name, rate [Hz] and filler [bytes] of each broadcast.
        subscribe: Names of broadcasts.
        every: Of the broadcasts received without a gap, only each so manieth gets a row.
        answer_s: How long it takes for an answer; negative if it does not answer [s].
        ask_hz: How often it asks [Hz].
        pause_s: How long it does nothing at all after each time it worked for as long [s].
    """

    name: str
    endpoint: str
    record: str
    publish: list[tuple[str, float, int]] = field(default_factory=list)
    subscribe: list[str] = field(default_factory=list)
    every: int = 1
    answer_s: float = -1.0
    ask_hz: float = 0.0
    pause_s: float = 0.0


class Module:
    """The running module."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._client = Client(plan.name, plan.endpoint)
        self._record = Path(plan.record).open("ab", buffering=1 << 16)  # noqa: SIM115
        self._counts: dict[str, collections.Counter[str]] = collections.defaultdict(
            collections.Counter
        )
        self._faults: list[str] = []
        self._connected = False
        self._asked = 0
        self._started = time.monotonic()
        self._stopping = False
        for name in plan.subscribe:
            self._client.subscribe(v.BROADCASTS[name], self._receiver(name))
        for name, _, _ in plan.publish:
            self._client.define(v.BROADCASTS[name])
        if plan.answer_s >= 0.0:
            self._client.respond(v.ASK, v.ANSWER, self._answer)
        if plan.ask_hz:
            self._client.every(1.0 / plan.ask_hz, self._ask)
        if plan.pause_s:
            self._client.every(2.0 * plan.pause_s, lambda: time.sleep(plan.pause_s))
        if plan.publish:
            self._client.every(_TICK_S, self._publish)
        self._client.every(_FLUSH_S, self._flush)

    def run(self) -> dict[str, Any]:
        """Serve until SIGTERM; what there was."""
        signal.signal(signal.SIGTERM, self._stop)
        while not self._stopping:
            try:
                self._client.listen(0.1)
            except Exception as error:  # noqa: BLE001 - whatever it is, it is to be reported
                self._faults.append(repr(error))
        self._flush()  # before it has taken its leave, which is no loss
        self._client.close()
        self._record.flush()
        return {name: dict(count) for name, count in self._counts.items()} | {
            "asked": self._asked,
            "complaints": dict(self._client.faults.counts),
            "faults": len(self._faults),
            "first faults": self._faults[:3],
        }

    def _stop(self, *_: object) -> None:
        self._stopping = True
        self._client.post(lambda: None)

    def _row(self, kind: Row, *values: int) -> None:
        # Spoilt messages hold any number; the good ones are small.
        small = [min(value, _LARGEST) for value in values]
        self._record.write(_ROW.pack(kind, time.monotonic_ns(), *small))

    def _flush(self) -> None:
        if self._client.connected is not self._connected:
            self._connected = not self._connected
            kind = Row.CONNECTED if self._connected else Row.LOST
            self._row(kind, 0, self._client.number, 0, 0, 0, 0)
        self._record.flush()

    def _publish(self) -> None:
        running = time.monotonic() - self._started
        published = self._counts["published"]
        for name, rate, size in self._plan.publish:
            due = int(running * rate) - published[name]
            for _ in range(min(due, _LONGEST_BURST)):
                value = v.sample(published[name], time.monotonic_ns(), size)
                self._client.publish(v.BROADCASTS[name], value)
                published[name] += 1

    def _receiver(self, name: str) -> Any:
        index = list(v.BROADCASTS).index(name)
        received, missed = self._counts["received"], self._counts["missed"]

        def receive(value: Sample, how: MessageInfo) -> None:
            received[name] += 1
            missed[name] += how.missed
            self._counts["first"].setdefault(name, how.sequence)
            self._counts["last"][name] = how.sequence
            if how.missed or received[name] % self._plan.every == 0:
                self._row(
                    Row.RECEIVED,
                    index,
                    how.publisher,
                    how.sequence,
                    how.missed,
                    value.number,
                    value.sent_ns,
                )

        return receive

    def _answer(self, ask: Sample) -> Sample:
        self._row(Row.HANDLED, 0, 0, 0, 0, ask.number, ask.sent_ns)
        time.sleep(self._plan.answer_s)
        return ask

    def _ask(self) -> None:
        number, sent_ns = self._asked, time.monotonic_ns()
        self._asked += 1

        def answered(_value: Sample, _how: MessageInfo) -> None:
            self._row(Row.ANSWERED, 0, 0, 0, 0, number, sent_ns)

        def failed(error: QueryError) -> None:
            self._counts["failures"][f"{type(error).__name__}: {error}"[:120]] += 1
            self._row(Row.FAILED, 0, 0, 0, 0, number, sent_ns)

        self._client.query_notify(
            v.ASK,
            v.sample(number, sent_ns, 8),
            v.ANSWER,
            timeout=_ASK_TIMEOUT_S,
            answered=answered,
            failed=failed,
        )


def main() -> None:
    summary = Module(Plan(**json.loads(sys.argv[1]))).run()
    sys.stdout.write(json.dumps(summary) + "\n")
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
