"""Modules that are forked from a warmed parent: what they share with it, and what they must not."""

from __future__ import annotations

import ctypes
import json
import os
import resource
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import psutil
import pytest

from hub.robomon import process
from hub.robomon.module_table import ModuleSpec
from hub.robomon.process import ModuleProcess, OrphanReaper, adopt_orphans
from hub.robomon.warm_parent import WarmParent
from tests.support.waiting import until

FACTS = """
import faulthandler, gc, json, os, random, resource, secrets, signal, sys, threading, time
import numpy
print(json.dumps({
    "name": __name__,
    "argv": sys.argv[1:],
    "orig_argv": sys.orig_argv[1:],
    "path": sys.path[0],
    "folder": os.getcwd(),
    "files": sorted(f for f in os.listdir("/proc/self/fd") if int(f) < 3 or
                    os.path.exists(f"/proc/self/fd/{f}")),
    "leads its group": os.getpgid(0) == os.getpid(),
    "session": os.getsid(0),
    "parent": os.getppid(),
    "handlers": [str(signal.getsignal(n)) for n in signal.valid_signals()],
    "blocked": [*signal.pthread_sigmask(signal.SIG_BLOCK, [])],
    "files it may open": resource.getrlimit(resource.RLIMIT_NOFILE),
    "niceness": os.nice(0),
    "environment": {k: v for k, v in os.environ.items()},
    "zone": time.tzname,
    "threads": [each.name for each in threading.enumerate()],
    "faults": faulthandler.is_enabled(),
    "collects": gc.isenabled(),
    "reads": sys.stdin.readline() if "reads" in sys.argv else "",
}))
print([random.random(), secrets.token_hex(8), numpy.random.random()])
sys.exit("the end")
"""


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as opened:
        yield opened


@pytest.fixture
def parent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stack: ExitStack) -> WarmParent:
    """One that is ready; this process adopts what it forks."""
    monkeypatch.chdir(tmp_path)
    if not adopt_orphans():
        pytest.skip("this system has no subreapers")
    stack.callback(ctypes.CDLL(None).prctl, 36, 0, 0, 0, 0)
    return ready(stack, ("numpy.random",))


def ready(stack: ExitStack, imports: Sequence[str]) -> WarmParent:
    made = stack.enter_context(closing(WarmParent(imports)))
    made.restart_if_ended()
    until(lambda: made.ready, 20.0)
    return made


class Starter:
    """Starts modules of these texts, and reads what they write."""

    def __init__(self, stack: ExitStack, folder: Path) -> None:
        self._stack = stack
        self._folder = folder
        self._count = 0

    def __call__(
        self, text: str, parent: WarmParent | None, arguments: Sequence[str] = (), **keys: Any
    ) -> ModuleProcess:
        (self._folder / "rune_told.py").write_text(text)
        command = (sys.executable, "-m", "rune_told")
        spec = ModuleSpec(**{"name": "told", "command": command, **keys})
        started = ModuleProcess(spec, arguments, parent)
        self._stack.callback(os.close, started.output)
        self._stack.callback(started.end)
        return started


@pytest.fixture
def start(stack: ExitStack, tmp_path: Path) -> Starter:
    return Starter(stack, tmp_path)


def written(module: ModuleProcess) -> str:
    """All that a module has written until its end."""
    assert module.wait(20.0)
    said = b""
    while chunk := os.read(module.output, 65536):
        said += chunk
    return said.decode()


def forked(module: ModuleProcess) -> bool:
    return Path(f"/proc/{module.pid}/comm").read_text().startswith("rune-")


LIVES = "import os, time\nos.write(1, b'1')\ntime.sleep(100.0)\n"


def lives(start: Starter, parent: WarmParent, **keys: Any) -> ModuleProcess:
    """A module that has begun and goes on."""
    module = start(LIVES, parent, **keys)
    assert os.read(module.output, 1) == b"1"
    return module


def test_a_forked_module_finds_what_a_spawned_one_finds(
    parent: WarmParent, start: Starter, monkeypatch: pytest.MonkeyPatch
) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    monkeypatch.setenv("SET_LATER", "yes \udcff")
    monkeypatch.setenv("NOTIFY_SOCKET", "of the daemon")
    keys: dict[str, Any] = {"nice": 3, "environment": (("TZ", "Asia/Tokyo"), ("MORE", "1"))}
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft - 7, hard))
    try:
        modules = [start(FACTS, each, ("--one", "two"), **keys) for each in (None, parent)]
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    texts = [written(module).splitlines() for module in modules]
    spawned, forked_ = (json.loads(text[0]) for text in texts)
    assert forked_ == spawned
    assert forked_["files"] == ["0", "1", "2"]
    assert forked_["parent"] == os.getpid()
    assert forked_["environment"]["SET_LATER"] == "yes \udcff"
    assert "NOTIFY_SOCKET" not in forked_["environment"]
    assert [text[2:] for text in texts] == [["the end"]] * 2
    assert [module.exit_code() for module in modules] == [1, 1]


def test_forked_modules_draw_different_random_numbers(parent: WarmParent, start: Starter) -> None:
    one, two = (
        json.loads(written(start(FACTS, parent)).splitlines()[1].replace("'", '"'))
        for _ in range(2)
    )
    assert not set(one) & set(two)


ENDS = [
    ("import sys; sys.exit(3)", 3, ""),
    ("import atexit; atexit.register(print, 'at the end')", 0, "at the end"),
    ("import threading; threading.Thread(target=print, args=['beside']).start()", 0, "beside"),
    ("1 / 0", 1, "ZeroDivisionError: division by zero"),
    ("import os; os.kill(os.getpid(), 9)", -9, ""),
    ("import os; os.kill(os.getpid(), 15)", -15, ""),
]


def test_a_forked_module_ends_as_a_spawned_one(parent: WarmParent, start: Starter) -> None:
    for text, code, said in ENDS:
        module = start(text, parent)
        assert written(module).strip().rpartition("\n")[2] == said
        assert module.exit_code() == code


def test_ps_shows_the_module_and_not_the_parent(parent: WarmParent, start: Starter) -> None:
    module = psutil.Process(lives(start, parent).pid)
    assert module.name() == "rune-rune_told"
    assert module.cmdline()[1:3] == ["-m", "rune_told"]


def test_modules_outlive_a_killed_parent_and_the_next_forks_again(
    parent: WarmParent, start: Starter
) -> None:
    first = lives(start, parent)
    os.kill(parent.pid, signal.SIGKILL)
    between = lives(start, parent)
    assert not forked(between)
    until(lambda: parent.restart_if_ended() or parent.ready, 20.0)
    last = lives(start, parent)
    assert forked(last)
    assert [each.exit_code() for each in (first, between, last)] == [None] * 3
    parent.close()
    assert [each.exit_code() for each in (first, between, last)] == [None] * 3


def test_a_parent_that_hangs_is_replaced_and_its_module_spawned(
    parent: WarmParent, start: Starter
) -> None:
    pid = parent.pid
    os.kill(pid, signal.SIGSTOP)
    until(lambda: psutil.Process(pid).status() == psutil.STATUS_STOPPED, 5.0)
    assert not forked(lives(start, parent))
    assert not psutil.pid_exists(pid)
    until(lambda: parent.restart_if_ended() or parent.ready, 20.0)
    assert forked(lives(start, parent))


def test_a_module_that_the_daemon_does_not_know_never_runs(
    parent: WarmParent, tmp_path: Path
) -> None:
    """Else two drivers would run when the daemon loses the answer and spawns another."""
    (tmp_path / "rune_told.py").write_text("open('it_ran', 'w')")
    spec = ModuleSpec(name="told", command=(sys.executable, "-m", "rune_told"))
    stdin, mine = os.pipe()
    module = parent.start(spec, (), (stdin, 1))
    os.close(stdin)
    assert module is not None
    os.close(mine)
    assert module.wait(10.0) == 0
    assert not (tmp_path / "it_ran").exists()


SPAWNED: list[dict[str, Any]] = [
    {"command": ("sleep", "100")},
    {"command": (sys.executable, "-c", "import time; time.sleep(100.0)")},
    {"environment": (("PYTHONMALLOC", "malloc"),)},
]


def test_what_a_fork_cannot_do_is_spawned(parent: WarmParent, start: Starter) -> None:
    for keys in SPAWNED:
        assert not forked(start("import time; time.sleep(100.0)", parent, **keys))
    assert parent.ready


THREADS = "import threading, time\nthreading.Thread(target=time.sleep, args=[60.0]).start()\n"


def test_nothing_is_forked_after_imports_that_start_threads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stack: ExitStack
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rune_busy.py").write_text(
        THREADS.replace("args=[60.0]", "args=[60.0], daemon=True")
    )
    parent = stack.enter_context(
        closing(WarmParent(("rune_busy",), clock=iter(range(1000)).__next__))
    )
    parent.restart_if_ended()
    until(lambda: parent.restart_if_ended() or not parent.pid, 20.0)
    for _ in range(5):
        parent.restart_if_ended()
    assert (parent.pid, parent.ready) == (0, False)


SESSIONS = """
import os, signal, time
for again in range(2):
    if os.fork() == 0:
        os.setsid()
        break
os.write(1, b"%d\\n" % os.getpid())
if again == 0:
    os.kill(os.getpid(), signal.SIGSTOP)
time.sleep(100.0)
"""


def test_the_reaper_finds_what_a_forked_module_has_forked_into_other_sessions(
    parent: WarmParent, start: Starter
) -> None:
    reaper = OrphanReaper()
    module = start(SESSIONS, parent)
    reaper.watch(module.pid)
    pids: list[int] = []
    until(lambda: pids.extend(map(int, os.read(module.output, 100).split())) or len(pids) == 3, 5.0)
    reaper.close()
    until(lambda: not any(map(_runs, pids)), 5.0)
    until(lambda: not _runs(parent.pid), 5.0)  # the parent has the mark as well
    for pid in set(pids) - {module.pid}:
        os.waitpid(pid, 0)  # this process has adopted them


def _runs(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def _strays(known: set[int]) -> set[int]:
    return {each.pid for each in psutil.Process().children()} - known


def test_strays_of_a_parent_are_found(parent: WarmParent, start: Starter) -> None:
    """What modules leave behind is adopted, whether they were forked or spawned."""
    known = {each.pid for each in psutil.Process().children()}
    module = start("import subprocess; subprocess.Popen(['sleep', '100'])", parent)
    assert module.wait(10.0)
    assert process.kill_leftovers(known) == 1
    until(lambda: process.kill_leftovers(known) == 0 and not _strays(known), 5.0)
