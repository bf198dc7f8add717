"""Processes that do not end by themselves, and the reaper that ends them when the daemon died."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import psutil
import pytest

from hub.errors import ModuleStartError
from hub.robomon import orphan_reaper, process
from hub.robomon.module_table import ModuleSpec
from hub.robomon.process import ModuleProcess, OrphanReaper
from tests.support.waiting import until


class Starter:
    """Starts modules that run a piece of Python and write a line when they are ready."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack

    def __call__(self, code: str) -> ModuleProcess:
        command = (sys.executable, "-I", "-S", "-c", code)
        started = ModuleProcess(ModuleSpec(name="one", command=command), ())
        self._stack.callback(os.close, started.output)
        self._stack.callback(started.end)
        return started


@pytest.fixture
def start() -> Iterator[Starter]:
    with ExitStack() as stack:
        yield Starter(stack)


@pytest.fixture
def watcher(monkeypatch: pytest.MonkeyPatch) -> Iterator[OrphanReaper]:
    monkeypatch.setattr(process, "END_TIMEOUT_S", 30.0)  # a busy machine starts it in seconds
    made = OrphanReaper()
    yield made
    made.close()


def ended(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def words(started: ModuleProcess) -> list[int]:
    return [int(word) for word in os.read(started.output, 100).split()]


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


def test_reaper_finds_what_left_its_session_or_is_stopped(
    watcher: OrphanReaper, start: Starter
) -> None:
    module = start(SESSIONS)
    watcher.watch(module.pid)
    pids: list[int] = []
    until(lambda: pids.extend(words(module)) or len(pids) == 3, 5.0)
    module.kill()
    module.wait(5.0)
    assert sum(map(ended, pids)) == 1, "the children are to outlive it"
    watcher.close()
    until(lambda: all(map(ended, pids)), 5.0)


def test_reaper_that_hangs_does_not_keep_the_daemon(
    watcher: OrphanReaper, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(orphan_reaper, "STOP_TIME_S", 0.1)
    monkeypatch.setattr(process, "END_TIMEOUT_S", 0.2)
    pid = watcher.pid
    os.kill(pid, signal.SIGSTOP)
    watcher.close()
    assert ended(pid)


def test_reaper_that_was_killed_is_replaced_by_one_that_knows_the_modules(
    watcher: OrphanReaper, start: Starter
) -> None:
    module = start("import os, time; os.write(1, b'1'); time.sleep(100.0)")
    words(module)
    watcher.watch(module.pid)
    first = watcher.pid
    os.kill(first, signal.SIGKILL)
    until(lambda: ended(first), 5.0)
    watcher.restart_if_ended()
    assert watcher.pid != first
    watcher.close()
    until(lambda: ended(module.pid), 5.0)  # who is killed takes a moment to end


def test_reaper_that_cannot_be_started_is_started_later(
    watcher: OrphanReaper, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EMFILE, "Too many open files")

    first = watcher.pid
    os.kill(first, signal.SIGKILL)
    until(lambda: ended(first), 5.0)
    with monkeypatch.context() as full:
        full.setattr(subprocess, "Popen", refuse)
        watcher.watch(os.getpid() + 1)
        watcher.forget(os.getpid() + 1)
        assert watcher.pid == 0
    watcher.restart_if_ended()
    assert watcher.pid not in (0, first)


def test_module_that_left_its_process_group_is_killed(start: Starter) -> None:
    module = start(
        "import os, time; os.setpgid(0, os.getpgid(os.getppid()))\n"
        "os.write(1, b'1'); time.sleep(100.0)"
    )
    words(module)
    module.kill()
    assert module.wait(5.0)


def test_no_descriptors_left_is_a_failed_start(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> None:
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr(os, "pipe", refuse)
    with pytest.raises(ModuleStartError, match="Too many open files"):
        ModuleProcess(ModuleSpec(name="one", command=("true",)), ())


def test_own_children_are_no_leftovers_and_ended_ones_are_not_counted(tmp_path: Path) -> None:
    """In a process of its own, which adopts what its child leaves behind."""
    code = tmp_path / "parent.py"
    code.write_text(
        "import subprocess\n"
        "from hub.robomon.process import adopt_orphans, kill_leftovers\n"
        "adopt_orphans()\n"
        "own = subprocess.Popen(['sleep', '100'])\n"
        "subprocess.run(['sh', '-c', 'true & exec sleep 0.1'])\n"
        "print(kill_leftovers({own.pid}), own.poll())\n"
        "subprocess.run(['sh', '-c', 'sleep 100 &'])\n"
        "print(kill_leftovers({own.pid}), own.poll())\n"
        "own.kill()\n"
    )
    said = subprocess.run([sys.executable, str(code)], capture_output=True, text=True, check=False)
    assert said.stdout.split() == ["0", "None", "1", "None"], said.stderr
