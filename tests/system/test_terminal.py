"""Terminals that send rubbish, stop reading or go away."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import time
from collections.abc import Callable
from functools import partial

import psutil
import pytest

from tests.support.waiting import until
from tests.system.harness import ConsoleProcess, HubProcess, Observer, in_soak

RUBBISH = [
    b"\xff\x80\xe9",
    b"\x1b[:u",
    b"\x1b[1114112u",
    b"\x1b[999999999999u",
    b"\x1b[119;1:3u",
    b"\x1b[<0;1",
    b"\x1b[200~" + b"w" * 5000 + b"\x1b[201~",
]


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


def test_no_input_ends_the_console(console: ConsoleProcess) -> None:
    chance = random.Random(3)
    for rubbish in [*RUBBISH, chance.randbytes(300).translate(None, b"\x03\x05\x10qQ?")]:
        os.write(console.terminal, rubbish)
        console.pump(0.2)
        assert console.process.poll() is None, rubbish
    os.write(console.terminal, b"\x1b[201~")
    console.pump(1.0)
    console.hold_until("w", lambda: "MOVING" in console.text)


def test_a_terminal_that_stops_reading_delays_no_stop(
    console: ConsoleProcess, observer: Observer
) -> None:
    # From here on nobody reads what the console writes, while keys still come.
    drive_unread(console, observer)
    with console.holding("w"):
        listen(observer, 1.2)
    console.type(" ")
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 5.0, "the stop did not come")
    console.pump(1.0)
    console.wait(lambda: "STANDING" in console.text, 10.0, "the picture does not come back")


def drive_unread(console: ConsoleProcess, observer: Observer) -> None:
    """Hold the key for forward, and read nothing, until the robot drives.

    What was held while the machine held up the console drives only once it is pressed anew, and
    after a time without keys, which the terminal's answers measure.
    """

    def held() -> bool:
        with console.holding("w"):
            listen(observer, 2.5, lambda: observer.truth.linear > 0.2)
        return observer.truth.linear > 0.2

    def let_go() -> None:
        console.pump(1.0)
        listen(observer, 0.1)

    until(held, 20.0, "keys do not reach the robot", meanwhile=let_go)


def listen(observer: Observer, seconds: float, enough: Callable[[], bool] = lambda: False) -> None:
    """Let the observer see what happens for a while, or until that is enough."""
    end = time.monotonic() + seconds
    while time.monotonic() < end and not enough():
        observer.client.listen(0.03)


def test_the_emergency_key_ends_it_even_under_the_list_of_actions(console: ConsoleProcess) -> None:
    console.type("\x10")  # ctrl+p
    console.wait(lambda: "What shall be done?" in console.text, 20.0, "the list does not open")
    console.type("q")
    found = ("Quit", "Q")
    console.wait(
        lambda: all(each in console.text for each in found) and "Stop" not in console.text,
        20.0,
        "the list ignores what is typed",
    )
    console.type("\x03")
    # 1 where the machine is so busy that its last resort was quicker.
    assert console.wait_ended() in {0, 1}


@pytest.mark.parametrize("how", ["q", *in_soak("SIGTERM")])
def test_a_terminal_that_has_stopped_reading_does_not_keep_the_console(
    console: ConsoleProcess, how: str
) -> None:
    stop_reading(console)
    if how == "q":
        console.type("q")
    else:
        console.process.terminate()
    # Nobody reads what it writes; it has to end all the same.
    until(lambda: console.process.poll() is not None, 10.0, "it does not end")


def test_a_terminal_that_has_stopped_reading_is_left_and_entered_all_the_same(
    console: ConsoleProcess,
) -> None:
    process = psutil.Process(console.process.pid)
    stop_reading(console)
    process.send_signal(signal.SIGTSTP)
    until(lambda: process.status() == psutil.STATUS_STOPPED, 5.0, "it does not stop")
    written = bytearray()
    until(
        lambda: b"\x1b[?1049l" in written,
        5.0,
        "the terminal was not left",
        meanwhile=lambda: written.extend(_unread(console)),
    )
    console.screen.reset()  # what the shell and others leave
    process.send_signal(signal.SIGCONT)
    console.wait_for_picture()
    console.hold_until("w", lambda: "MOVING" in console.text)


def _unread(console: ConsoleProcess) -> bytes:
    """What it has written and nobody read, as far as the system has it ready."""
    with contextlib.suppress(BlockingIOError):
        return os.read(console.terminal, 1 << 16)
    return b""


def stop_reading(console: ConsoleProcess) -> None:
    """Hold a key that changes the picture, and read nothing, until the console can write no more.

    What was held while the machine held up the console drives only once it is pressed anew, and
    the terminal has answered.
    """

    def stuck() -> bool:
        end = time.monotonic() + 3.0
        with console.holding("a"):
            while time.monotonic() < end:
                if _is_stuck(console):
                    return True
        return False

    until(
        stuck, 30.0, "the console does not fill the terminal", meanwhile=partial(console.pump, 1.0)
    )


def _is_stuck(console: ConsoleProcess) -> bool:
    """Whether the console waits for the terminal to take more: its output has not moved on."""
    import array
    import fcntl
    import termios

    waiting = array.array("i", [0])
    fcntl.ioctl(console.terminal, termios.FIONREAD, waiting)
    time.sleep(0.1)
    later = array.array("i", [0])
    fcntl.ioctl(console.terminal, termios.FIONREAD, later)
    return waiting[0] > 2000 and waiting[0] == later[0]


def test_a_terminal_that_has_gone_ends_the_console(
    hub: HubProcess, start_console: Callable[..., ConsoleProcess]
) -> None:
    console = start_console(hub.endpoint)
    console.wait_for_picture()
    other = os.open(os.devnull, os.O_RDWR)
    os.dup2(other, console.terminal)  # the last end of the terminal is closed
    os.close(other)
    until(lambda: console.process.poll() is not None, 10.0, "it lives on")
