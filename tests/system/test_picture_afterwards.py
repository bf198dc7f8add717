"""Whatever happens to the terminal, it shows the right picture afterwards."""

from __future__ import annotations

import fcntl
import os
import signal
import struct
import termios
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pyte
import pytest

from tests.system.harness import ConsoleProcess, HubProcess
from tests.waiting import until

PICTURE_ROWS = 20
"""Below them are words that change by themselves."""
STABLE_S = 0.6


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


def picture(console: ConsoleProcess) -> list[tuple[str, ...]]:
    """What is seen of the camera's picture, which stands still as the robot does."""
    buffer, columns = console.screen.buffer, console.screen.columns
    return [seen(buffer[row][column]) for row in range(PICTURE_ROWS) for column in range(columns)]


def seen(cell: pyte.screens.Char) -> tuple[str, ...]:
    """The colours of the upper and lower half of a cell, or its character too."""
    halves = {"▀": (cell.fg, cell.bg), " ": (cell.bg, cell.bg)}
    return halves.get(cell.data, (cell.data, cell.fg, cell.bg))


def settled(console: ConsoleProcess) -> list[tuple[str, ...]]:
    """The picture once it has not changed for a while: then it is exact."""
    console.wait_for_picture()
    known, since = picture(console), time.monotonic()

    def still() -> bool:
        nonlocal known, since
        if (now := picture(console)) != known:
            known, since = now, time.monotonic()
        return time.monotonic() - since > STABLE_S

    console.wait(still, 30.0, "the picture does not settle")
    return known


def resize(console: ConsoleProcess, columns: int, rows: int) -> None:
    """The window becomes larger or smaller."""
    size = struct.pack("HHHH", rows, columns, 0, 0)
    fcntl.ioctl(console.terminal, termios.TIOCSWINSZ, size)
    console.screen.resize(rows, columns)
    os.killpg(console.process.pid, signal.SIGWINCH)


def other_sizes(console: ConsoleProcess) -> None:
    for columns, rows in ((20, 5), (200, 60), (100, 30)):
        resize(console, columns, rows)
        console.pump(0.5)


def suspend(console: ConsoleProcess) -> None:
    process = psutil.Process(console.process.pid)
    process.send_signal(signal.SIGTSTP)
    until(lambda: process.status() == psutil.STATUS_STOPPED, 10.0)
    console.pump(0.2)
    console.screen.reset()  # what the shell and others leave
    process.send_signal(signal.SIGCONT)


def stop_reading(_: ConsoleProcess) -> None:
    time.sleep(2.5)


def open_the_list(console: ConsoleProcess) -> None:
    console.type("\x10")  # ctrl+p
    console.wait(lambda: "What shall be done?" in console.text, 20.0, "the list does not open")
    console.pump(0.5)
    console.wait(lambda: "Ends the console" in console.text, 20.0, "the picture is over the list")
    console.type("\x1b")
    console.wait(lambda: "What shall be done?" not in console.text, 20.0, "the list stays")


@pytest.mark.parametrize("event", [other_sizes, suspend, stop_reading, open_the_list])
def test_the_picture_is_right_afterwards(
    console: ConsoleProcess, event: Callable[[ConsoleProcess], None]
) -> None:
    before = settled(console)
    event(console)
    console.wait(lambda: picture(console) == before, 20.0, "the picture is another one")


def test_ctrl_z_gives_the_terminal_to_the_shell_until_it_has_the_console_go_on(
    hub: HubProcess, start_console: Callable[..., ConsoleProcess], tmp_path: Path
) -> None:
    told = tmp_path / "told"
    job = f'set -m; "$@"; echo $? > {told}; fg; echo $? >> {told}'
    console = start_console(hub.endpoint, within=["bash", "-c", job, "bash"])
    before = settled(console)
    console.type("\x1a")
    console.wait(lambda: told.exists() and "\n" in told.read_text(), 20.0, "it is not suspended")
    assert int(told.read_text()) == 128 + signal.SIGSTOP
    console.wait(lambda: picture(console) == before, 20.0, "the picture is another one")
    console.type("q")
    console.wait_ended()
    assert told.read_text().splitlines()[-1] == "0"


def test_ctrl_z_does_nothing_where_no_shell_would_have_the_console_go_on(
    console: ConsoleProcess,
) -> None:
    console.type("\x1a")
    console.wait(lambda: "Ctrl-Z does nothing here" in console.text, 20.0, "it says nothing")
