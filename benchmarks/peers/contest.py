"""Runs of one contender: its processes started, watched and ended, and what they cost."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import random
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from benchmarks.figures import say
from benchmarks.peers.job import Job
from benchmarks.peers.page import DONE, MEASURING, Page

ROOT = Path(__file__).resolve().parents[2]
PEERS_PYTHON = ROOT / ".venv-bench/bin/python"
_START_S = 20.0
_WINDOW, _LARGE_WINDOW = 200, 60
_LARGE = 5000


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """A bus that takes part.

    Attributes:
        name: As figures call it.
        module: File in this folder that uses it.
        transport: "tcp", "ipc", or "" where there is no broker.
        needs: Packages of the peers' own environment; empty: it runs in Rune's.
        program: A program that must be installed, if any.
        options: What its module wants to know.
    """

    name: str
    module: str
    transport: str = "tcp"
    needs: str = ""
    program: str = ""
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def python(self) -> str:
        return str(PEERS_PYTHON) if self.needs else sys.executable

    def missing(self) -> str:
        """Why it cannot take part; empty if it can."""
        if self.program and not shutil.which(self.program, path=os.environ["PATH"] + ":/usr/sbin"):
            return f"the program {self.program} is not installed"
        if self.needs:
            there = list(ROOT.glob(f".venv-bench/lib/python3*/site-packages/{self.needs}"))
            if not there or not PEERS_PYTHON.exists():
                return f"{self.needs} is not installed; run `make bench-peers`"
        plane = self.options.get("plane", "STATE")
        if self.module == "rune_bus" and importlib.util.find_spec("hub"):
            from hub.ipc.definition import Plane

            if not hasattr(Plane, plane):
                return f"the bus has no plane {plane}"
        return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What one run gave.

    Attributes:
        per_second: Messages each subscriber received [1/s].
        lost: Messages that did not come, of all subscribers together.
        stalls: How often the sender waited without success.
        sender_us: CPU time of the sender per message sent [us].
        broker_us: CPU time of the broker per message sent [us].
        receiver_us: CPU time of all subscribers together per message sent [us].
        broker_mb: Resident memory of the broker [MB].
        times: Latencies or round trips, sorted [us].
    """

    per_second: float
    lost: int
    stalls: int
    sender_us: float
    broker_us: float
    receiver_us: float
    broker_mb: float
    times: tuple[float, ...]

    @property
    def total_us(self) -> float:
        return self.sender_us + self.broker_us + self.receiver_us

    @property
    def p50(self) -> float:
        return self.percentile(0.5)

    @property
    def p99(self) -> float:
        return self.percentile(0.99)

    def percentile(self, part: float) -> float:
        return self.times[min(int(len(self.times) * part), len(self.times) - 1)]


class Stage:
    """A contender's broker, running, on which runs take place one after the other."""

    def __init__(self, contender: Contender, folder: Path) -> None:
        self.contender = contender
        self._folder = folder
        self._log = folder / f"{contender.name}.log"
        self._count = 0
        if contender.transport == "ipc":
            endpoint = f"ipc://{folder}/{contender.name}"
        else:
            endpoint = f"tcp://127.0.0.1:{_free_port()}"
        self._job = Job(
            page=str(folder / f"page-{contender.name}"),
            endpoint=endpoint,
            options=dict(contender.options),
        )
        self._broker: subprocess.Popen[bytes] | None = None
        if contender.transport:
            self._broker = self._start("broker", self._job)
            self._wait_listening()

    def flow(self, size: int, subscribers: int, seconds: float, **options: Any) -> Outcome:
        """As many messages as go through without a loss."""
        window = _WINDOW if size < _LARGE else _LARGE_WINDOW
        job = self._next(size=size, subscribers=subscribers, seconds=seconds, window=window)
        return self._run(replace(job, options=job.options | options), "send", "receive")

    def pace(self, size: int, hertz: float, seconds: float) -> Outcome:
        """A steady stream and what its messages take."""
        return self._run(self._next(size=size, hertz=hertz, seconds=seconds), "send", "receive")

    def queries(self, seconds: float) -> Outcome:
        """One query after the other."""
        return self._run(self._next(seconds=seconds), "ask", "answer")

    def rest(self, seconds: float) -> tuple[float, float]:
        """CPU [% of a core] and resident memory [MB] of the broker while nothing is sent."""
        assert_running(self._broker)
        started, before = time.monotonic(), cpu_ns(self._broker.pid)
        time.sleep(seconds)
        used = cpu_ns(self._broker.pid) - before
        return used * 1e-7 / (time.monotonic() - started), resident_mb(self._broker.pid)

    @contextlib.contextmanager
    def crowd(self, modules: int, processes: int) -> Iterator[None]:
        """A number of modules that are connected and idle, shared among some processes."""
        options = self._job.options | {"modules": modules // processes}
        job = self._next(subscribers=processes, options=options)
        with ExitStack() as stack:
            page = self._page(job, stack)
            for index in range(processes):
                process = self._start("crowd", replace(job, index=index))
                stack.callback(_end, process)
            _wait(lambda: page.ready(processes), f"{modules} modules connected", [])
            yield

    def close(self) -> None:
        if self._broker is not None:
            _end(self._broker)

    def _next(self, **changes: Any) -> Job:
        self._count += 1
        return replace(self._job, page=f"{self._job.page}.{self._count}", **changes)

    def _page(self, job: Job, stack: ExitStack) -> Page:
        path = Path(job.page)
        stack.callback(path.unlink)
        return Page(path, create=True)

    def _start(self, role: str, job: Job) -> subprocess.Popen[bytes]:
        command = [self.contender.python, "-m", "benchmarks.peers.process", role]
        with self._log.open("ab") as log:
            return subprocess.Popen(
                [*command, self.contender.module, job.to_json(), str(os.getpid())],
                cwd=ROOT,
                env=os.environ | {"PYTHONPATH": str(ROOT)},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )

    def _run(self, job: Job, sending: str, receiving: str) -> Outcome:
        with ExitStack() as stack:
            page = self._page(job, stack)
            receivers = []
            for index in range(job.subscribers):
                receivers.append(self._start(receiving, replace(job, index=index)))
                stack.callback(_end, receivers[-1])
            sender = self._start(sending, job)
            stack.callback(_end, sender)
            watched = [sender, *receivers] + ([self._broker] if self._broker else [])
            what = f"a run of {self.contender.name}; see {self._log}"
            _wait(lambda: page.phase >= MEASURING, f"the start of {what}", watched)
            before = [cpu_ns(process.pid) for process in watched]
            _wait(lambda: page.phase == DONE, f"the end of {what}", watched)
            used = [cpu_ns(p.pid) - b for p, b in zip(watched, before, strict=True)]
            return self._outcome(job, page, used)

    def _outcome(self, job: Job, page: Page, used: Sequence[int]) -> Outcome:
        received = [page.received(index) for index in range(job.subscribers)]
        each = [value * 1e-3 / max(page.sent, 1) for value in used]
        return Outcome(
            per_second=min(received) / page.seconds,
            lost=page.sent * job.subscribers - sum(received),
            stalls=page.stalls,
            sender_us=each[0],
            broker_us=each[-1] if self._broker else 0.0,
            receiver_us=sum(each[1 : job.subscribers + 1]),
            broker_mb=resident_mb(self._broker.pid) if self._broker else 0.0,
            times=tuple(sorted(t for index in range(job.subscribers) for t in page.times(index))),
        )

    def _wait_listening(self) -> None:
        assert_running(self._broker)
        _wait(self._listening, f"the broker of {self.contender.name}", [self._broker])

    def _listening(self) -> bool:
        scheme, _, rest = self._job.endpoint.partition("://")
        if scheme == "ipc":
            return any(path.is_socket() for path in self._folder.glob(Path(rest).name + "*"))
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self._job.port)) == 0


def assert_running(process: subprocess.Popen[bytes] | None) -> None:
    """Refuse to measure a broker that there is not."""
    if process is None:
        text = "this contender has no broker"
        raise ValueError(text)


@contextlib.contextmanager
def stages(contenders: Sequence[Contender]) -> Iterator[dict[str, Stage]]:
    """The brokers of all contenders that can take part, by name."""
    memory = Path("/dev/shm")
    before = set(memory.glob("*.zenoh"))
    with ExitStack() as stack:
        stack.callback(_sweep, memory, before)
        where = memory if memory.is_dir() else None
        folder = tempfile.mkdtemp(prefix="rune-bench-", dir=where)
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        ready = {}
        for contender in contenders:
            why = contender.missing()
            if why:
                say(f"without {contender.name}: {why}")
                continue
            ready[contender.name] = stage = Stage(contender, Path(folder))
            stack.callback(stage.close)
        yield ready


def _sweep(memory: Path, before: set[Path]) -> None:
    """Remove the shared memory that killed Zenoh processes leave behind."""
    for left in set(memory.glob("*.zenoh")) - before:
        left.unlink(missing_ok=True)


def cpu_ns(pid: int) -> int:
    """CPU time of all threads of a process [ns]."""
    total = 0
    for task in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with contextlib.suppress(OSError):  # a thread may end while we look
            total += int(task.read_text().split()[0])
    return total


def resident_mb(pid: int) -> float:
    """Resident memory of a process [MB]."""
    status = Path(f"/proc/{pid}/status").read_text()
    kilobytes = next(line.split()[1] for line in status.splitlines() if line.startswith("VmRSS"))
    return int(kilobytes) / 1024


def median(outcomes: Sequence[Outcome], attribute: str) -> float:
    """The median of one attribute over repetitions."""
    return statistics.median(getattr(outcome, attribute) for outcome in outcomes)


def _wait(
    met: Any, what: str, processes: Sequence[subprocess.Popen[bytes]], timeout: float = _START_S
) -> None:
    deadline = time.monotonic() + timeout
    while not met():
        dead = [process for process in processes if process.poll() is not None]
        if dead or time.monotonic() > deadline:
            why = f"process {dead[0].args!r} ended" if dead else "it took too long"
            text = f"{what} did not come: {why}"
            raise TimeoutError(text)
        time.sleep(0.004)


def _free_port() -> int:
    """The first of five ports that no program listens at, outside the range of client ports."""
    while True:
        port = random.randrange(18_000, 30_000)
        with ExitStack() as stack:
            try:
                for place in range(5):
                    probe = stack.enter_context(socket.socket())
                    probe.bind(("127.0.0.1", port + place))
            except OSError:
                continue
            return port


def _end(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGKILL)
    process.wait()
