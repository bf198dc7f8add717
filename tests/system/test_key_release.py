"""Keys on a terminal that tells when they go up (kitty keyboard protocol), to the wheels."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import pytest

from tests.system.conftest import LAYOUT
from tests.system.harness import STILL, ConsoleProcess, HubProcess, Observer

TELLS_RELEASES = "\x1b[?27u"
W_DOWN, W_REPEATS, W_UP = "\x1b[119;;119u", "\x1b[119;1:2;119u", "\x1b[119;1:3u"


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture
def console(hub: HubProcess, start_console: Callable[..., ConsoleProcess]) -> ConsoleProcess:
    started = start_console(hub.endpoint, columns=200)
    started.wait_for_picture()
    started.wait(lambda: "STANDING" in started.text, 10.0)
    started.wait(lambda: "release: timed" in started.text, 10.0)
    started.type(TELLS_RELEASES)
    started.wait(lambda: "release: exact" in started.text, 10.0)
    return started


def test_a_terminal_that_does_not_tell_a_key_of_the_layout_is_named_at_the_start(
    hub: HubProcess, tmp_path: Path, stack: ExitStack
) -> None:
    layout = tmp_path / "keypad.xml"
    layout.write_text(LAYOUT.format(hub=hub.endpoint).replace('key="w"', 'key="kp_8"'))
    console = stack.enter_context(closing(ConsoleProcess(["run", str(layout)], columns=200)))
    console.wait(lambda: "this terminal does not tell kp_8" in console.text, 20.0, "not told")


def test_a_terminal_that_tells_releases_of_arrows_alone_is_timed(console: ConsoleProcess) -> None:
    console.type("\x1b[?3u")
    console.wait(lambda: "release: timed" in console.text, 10.0, "it is taken for exact")


@contextmanager
def w_held(console: ConsoleProcess) -> Iterator[None]:
    """One press, no repeats: those may belong to a key that was pressed later."""
    console.type(W_DOWN)
    yield
    console.type(W_UP)


def drives(console: ConsoleProcess, observer: Observer, far: float) -> bool:
    """Whether one press drives this far [m]; a pause of a busy machine ends the press."""
    start = observer.truth.x
    end = time.monotonic() + 3.0 + far / 0.3
    with w_held(console):
        while observer.truth.x - start < far and time.monotonic() < end:
            console.pump(0.02)
    return observer.truth.x - start >= far


def test_a_key_drives_until_it_goes_up(console: ConsoleProcess, observer: Observer) -> None:
    # Farther than a key would be held for whose release nobody tells.
    assert any(drives(console, observer, 1.0) for _ in range(10))
    observer.wait(lambda: console.pump(0.02) or abs(observer.truth.linear) < STILL, 5.0)
    assert observer.truth.commanded_linear == 0.0


def test_a_terminal_that_falls_silent_drives_no_further_until_the_key_is_pressed_anew(
    console: ConsoleProcess, observer: Observer
) -> None:
    with w_held(console):
        observer.wait(lambda: console.pump(0.02) or observer.truth.linear > 0.2, 10.0)
        # Nothing is read from here on, and nothing answered: the line is cut.
        observer.wait(lambda: abs(observer.truth.linear) < STILL, 10.0, "it drives on")
        moved = []
        for _ in range(20):
            console.type(W_REPEATS)
            console.pump(0.05)
            moved.append(observer.truth.commanded_linear)
        assert not any(moved)
    with w_held(console):
        observer.wait(lambda: console.pump(0.02) or observer.truth.linear > 0.2, 10.0)
