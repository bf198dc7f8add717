"""Fixtures for every test: nothing of the developer's own, nothing left behind."""

from __future__ import annotations

import contextlib
import gc
import itertools
import json
import math
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Generator, Iterator
from typing import Any

import psutil
import pytest

from tests.support import examples, own_environment, warm_start
from tests.support.sharing_out import shared_out
from tests.support.waiting import until

own_environment.enter()
warm_start.use()
examples.choose()


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is collected stays: nothing of it is rubbish, neither now nor while the tests run."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Have tests with real processes come first, where several workers share the tests."""
    workers = getattr(config, "workerinput", {}).get("workercount", 1)
    if workers > 1:
        own = [config.rootpath / "tests" / room for room in ("soak", "system")]
        items[:] = shared_out(
            items,
            workers,
            file_of=lambda item: item.path,
            waits=lambda item: any(map(item.path.is_relative_to, own)),
        )


@pytest.fixture(scope="session", autouse=True)
def own_home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Home and folder of sockets of all tests of this process."""
    with tempfile.TemporaryDirectory(prefix="rune-") as sockets:  # a short path, as they need
        os.environ["HOME"] = str(tmp_path_factory.mktemp("home"))
        os.environ["XDG_RUNTIME_DIR"] = sockets
        os.environ["RUNE_RUNTIME_DIR"] = sockets
        yield


_numbers = itertools.count()


@pytest.fixture(autouse=True)
def own_folders(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Logs and sockets go into the test's own folders; who writes into them makes them."""
    own = tmp_path_factory.getbasetemp() / f"own-{next(_numbers)}"
    for variable in ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"):
        monkeypatch.setenv(variable, str(own / variable.lower()))


@pytest.fixture(autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """A test that leaves threads or processes of ours behind fails."""
    with leaving_nothing():
        yield


@contextlib.contextmanager
def leaving_nothing() -> Iterator[None]:
    """Fail if threads or processes of ours are there at the end that were not at the start.

    A hub that several tests share may start a module again. "Dummy-" are threads of compiled
    libraries; Python does not see their end.
    """
    threads = set(threading.enumerate())
    children = {child.pid for child in _descendants()}
    yield

    def left() -> list[str]:
        running = [_shown(child) for child in _descendants() if not children & _line(child)]
        return [each for each in running if each] + [
            f"thread {thread.name}"
            for thread in set(threading.enumerate()) - threads
            if not thread.name.startswith(("asyncio_", "textual-", "pymonitor", "Dummy-"))
        ]

    until(lambda: not left(), 5.0, lambda: f"left behind: {left()}")


def _line(process: psutil.Process) -> set[int]:
    """A process and those above it."""
    with contextlib.suppress(psutil.NoSuchProcess):
        return {process.pid, *(each.pid for each in process.parents())}
    return {process.pid}


def _shown(process: psutil.Process) -> str:
    """A process in words; empty: it has just ended."""
    with contextlib.suppress(psutil.NoSuchProcess):
        return f"process {process.pid}: {process.name()}"
    return ""


def _descendants() -> list[psutil.Process]:
    """All processes below this one.

    Most tests have none, and the system tells so at once; to find some, psutil reads about every
    process of the machine.
    """
    forked = [psutil.Process(pid) for pid in warm_start.running() if psutil.pid_exists(pid)]
    if hasattr(os, "waitid") and not forked:
        try:
            os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)  # reaps none
        except ChildProcessError:
            return []
    below = [psutil.Process().children(recursive=True)]
    for each in forked:
        with contextlib.suppress(psutil.NoSuchProcess):  # it has just ended
            below.append([each, *each.children(recursive=True)])
    return list(itertools.chain.from_iterable(below))


@pytest.fixture
def tell(request: pytest.FixtureRequest, capfd: pytest.CaptureFixture[str]) -> Callable[..., None]:
    """Writes one JSON line with the test's name and figures, past pytest's capture.

    Then every bar has to hold: a test that fails tells of all it has found, not of the first.
    """

    def write(*, bars: dict[str, bool], **figures: Any) -> None:
        failed = [bar for bar, holds in bars.items() if not holds]
        with capfd.disabled():
            line = json.dumps({"test": request.node.name, **_finite(figures), "failed": failed})
            sys.stdout.write(f"\n{line}\n")
            sys.stdout.flush()
        assert failed == []

    return write


def _finite(value: Any) -> Any:
    """The same without what JSON cannot say; what never happened has no figure."""
    if isinstance(value, dict):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(each) for each in value]
    return value if not isinstance(value, float) or math.isfinite(value) else None
