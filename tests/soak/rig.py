"""A central and modules as processes of their own, what they wrote down, and what they cost."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import psutil

from hub.errors import HubError
from hub.ipc.client import Client
from hub.ipc.wire.control import Listing
from tests.soak import vocabulary as v
from tests.soak.module_process import COLUMNS, Plan, Row
from tests.support import warm_start
from tests.support.ports import free_port
from tests.support.waiting import until

ROOT = Path(__file__).parents[2]
Rows = npt.NDArray[np.int64]
KIND, AT, MESSAGE, PUBLISHER, SEQUENCE, MISSED, NUMBER, SENT = range(len(COLUMNS))


@dataclass(frozen=True, slots=True, kw_only=True)
class Vitals:
    """What a process costs now: resident memory [MB], open descriptors, threads."""

    memory_mb: float
    descriptors: int
    threads: int

    @classmethod
    def of(cls, pid: int) -> Vitals:
        """Those of a running process."""
        process = psutil.Process(pid)
        memory = process.memory_info().rss / 1e6
        return cls(
            memory_mb=round(memory, 2),
            descriptors=process.num_fds(),
            threads=process.num_threads(),
        )


class Started:
    """A Python program of ours; standard error goes to a file."""

    def __init__(self, command: Sequence[str], log: Path) -> None:
        self.log = log
        with log.open("ab") as file:
            self.process = warm_start.start(
                command,
                environment=os.environ,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=file.fileno(),
                folder=ROOT,
            )

    @property
    def pid(self) -> int:
        return self.process.pid

    def line(self) -> dict[str, Any]:
        """The next JSON line it writes."""
        assert self.process.stdout is not None
        text = self.process.stdout.readline().decode()
        assert text, f"it ended: {self.log.read_text()[-2000:]}"
        found: dict[str, Any] = json.loads(text)
        return found

    def kill(self) -> None:
        """As `kill -9`."""
        self.process.kill()
        self._rest()

    def end(self, timeout: float = 20.0) -> str:
        """Ask it to end; what else it wrote, which is less than a pipe holds."""
        if self.process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.kill()
        return self._rest()

    def _rest(self) -> str:
        self.process.wait()
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.close()
        if self.process.stdout.closed:
            return ""
        with self.process.stdout as said:
            return said.read().decode()


class CentralProcess(Started):
    """A central.

    Attributes:
        ports: TCP ports of its five sockets; empty without TCP.
        paths: ipc paths of its five sockets; empty without ipc.
        listening_ns: When all were bound, on the monotonic clock [ns].
    """

    def __init__(self, endpoints: Sequence[str], log: Path, *, prefix: Sequence[str] = ()) -> None:
        command = [*prefix, sys.executable, "-m", "tests.soak.central_process", *endpoints]
        super().__init__(command, log)
        found = self.line()
        self.listening_ns = int(found["listening_ns"])
        self.ports: list[int] = []
        self.paths: list[str] = []
        for endpoint in found["endpoints"]:
            scheme, _, rest = endpoint.partition("://")
            if scheme == "tcp":
                self.ports = [int(rest.rpartition(":")[2]), *found["ports"]]
            else:
                self.paths = [rest, *found["paths"]]

    def vitals(self) -> Vitals:
        """What it costs now."""
        return Vitals.of(self.pid)


class ModuleProcess(Started):
    """A module that writes down what it sees."""

    def __init__(self, plan: Plan, log: Path, *, prefix: Sequence[str] = ()) -> None:
        self._record = Path(plan.record)
        self.plan = plan
        text = json.dumps(asdict(plan))
        command = [*prefix, sys.executable, "-m", "tests.soak.module_process", text]
        super().__init__(command, log)
        self.summary: dict[str, Any] = {}

    def rows(self, kind: Row | None = None) -> Rows:
        """What happened so far, one row each."""
        raw = self._record.read_bytes() if self._record.exists() else b""
        whole = len(raw) - len(raw) % (8 * len(COLUMNS))
        rows = np.frombuffer(raw[:whole], np.int64).reshape(-1, len(COLUMNS))
        return rows if kind is None else rows[rows[:, KIND] == kind]

    def received(self, name: str) -> Rows:
        """The broadcasts of this name that its handler was called with."""
        rows = self.rows(Row.RECEIVED)
        return rows[rows[:, MESSAGE] == list(v.BROADCASTS).index(name)]

    def finish(self) -> dict[str, Any]:
        """End it; its summary."""
        lines = self.end().splitlines()
        assert lines, f"{self.plan.name} died: {self.log.read_text()[-2000:]}"
        self.summary = json.loads(lines[-1])
        return self.summary


class Rig:
    """A central with modules, all ended when it is closed."""

    def __init__(self, folder: Path, *, transport: str = "tcp", prefix: Sequence[str] = ()) -> None:
        self.folder = folder
        self.prefix = tuple(prefix)
        port, path = free_port(), folder / "central"
        addresses = {"tcp": f"tcp://127.0.0.1:{port}", "ipc": f"ipc://{path}"}
        self.endpoints = list(addresses.values()) if transport == "both" else [addresses[transport]]
        self.modules: dict[str, ModuleProcess] = {}
        self.others: list[Started] = []
        self.central = self.start_central()

    def start_central(self) -> CentralProcess:
        """At the same endpoints every time."""
        log = self.folder / "central.log"
        self.central = CentralProcess(self.endpoints, log, prefix=self.prefix)
        return self.central

    def module(self, name: str, *, endpoint: str = "", **plan: Any) -> ModuleProcess:
        """Start a module that does what `Plan` tells."""
        record = self.folder / f"{name}-{len(self.modules)}.rows"
        whole = Plan(name=name, endpoint=endpoint or self.endpoints[0], record=str(record), **plan)
        log = self.folder / f"{name}.log"
        started = ModuleProcess(whole, log, prefix=self.prefix)
        self.modules[name] = started
        return started

    def other(self, *command: str) -> Started:
        """Start another program of this folder of tests: a module's name and arguments."""
        log = self.folder / f"other-{len(self.others)}.log"
        whole = [*self.prefix, sys.executable, "-m", *command]
        self.others.append(Started(whole, log))
        return self.others[-1]

    def listing(self, timeout: float = 10.0) -> Listing:
        """What central tells to a client of its own."""
        client = Client(f"auditor {os.getpid()} {time.monotonic_ns()}", self.endpoints[0])
        try:
            client.wait_connected(timeout)
            return client.directory.listing(timeout)
        finally:
            client.close()

    def dropped(self) -> dict[str, int]:
        """What central has dropped, by reason."""
        return {count.reason: count.count for count in self.listing().dropped}

    def wait_flowing(self, subscriber: ModuleProcess, *names: str) -> None:
        """Until it has received each of these."""
        for name in names:
            until(lambda name=name: len(subscriber.received(name)), 20.0, f"no {name} came")

    def wait_drained(self, publisher: ModuleProcess, *subscribers: ModuleProcess) -> None:
        """End the publisher and wait until nothing of it comes any more."""
        publisher.finish()

        def rows() -> list[int]:
            return [len(subscriber.rows()) for subscriber in subscribers]

        seen, quiet_since = rows(), time.monotonic()

        def quiet() -> bool:
            nonlocal seen, quiet_since
            now = rows()
            if now != seen:
                seen, quiet_since = now, time.monotonic()
            return time.monotonic() - quiet_since > 0.3

        until(quiet, 30.0, "it never became quiet")

    def close(self) -> None:
        """End all that still runs."""
        for started in (*self.others, *self.modules.values(), self.central):
            with contextlib.suppress(HubError, ValueError):
                started.end()


def latency_ms(rows: Rows, start_ns: int = 0, end_ns: int = 1 << 62) -> dict[str, float]:
    """From publish to handler, of what was sent in this time [ms].

    Beside the median, the 99th percentile and the largest of all there is the 99th percentile of a
    typical second: the median over the seconds. Where other work shares the processors for
    moments, only this one tells of the bus.
    """
    chosen = rows[(rows[:, SENT] >= start_ns) & (rows[:, SENT] < end_ns)]
    if not len(chosen):
        return dict.fromkeys(("p50_ms", "p99_ms", "max_ms", "typical_p99_ms"), float("nan"))
    taken = (chosen[:, AT] - chosen[:, SENT]) / 1e6
    second = (chosen[:, SENT] - chosen[0, SENT]) // 10**9
    typical = np.median([np.percentile(taken[second == each], 99) for each in np.unique(second)])
    p50, p99 = np.percentile(taken, (50, 99))
    figures = {"p50_ms": p50, "p99_ms": p99, "max_ms": taken.max(), "typical_p99_ms": typical}
    return {name: round(float(figure), 3) for name, figure in figures.items()}


def lost(rows: Rows, published: int) -> int:
    """How many did not come of those from the first that came to the last that was published."""
    if not len(rows):
        return published
    return published - int(rows[:, NUMBER].min()) - len(set(rows[:, NUMBER].tolist()))
