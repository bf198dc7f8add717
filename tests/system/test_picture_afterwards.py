"""Whatever happens to the terminal, it shows the right picture afterwards."""

from __future__ import annotations

import fcntl
import itertools
import os
import shutil
import signal
import struct
import subprocess
import tempfile
import termios
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from pathlib import Path

import psutil
import pyte
import pytest

from hub.gcm.navigation import VELOCITY_COMMAND
from tests.support.waiting import until
from tests.system.conftest import LAYOUT
from tests.system.harness import ConsoleProcess, HubProcess, Observer, in_soak
from tests.system.terminal_process import TerminalProcess

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


def stop_reading_for_a_minute(_: ConsoleProcess) -> None:
    time.sleep(60.0)


def open_the_list(console: ConsoleProcess) -> None:
    console.type("\x10")  # ctrl+p
    console.wait(lambda: "What shall be done?" in console.text, 20.0, "the list does not open")
    console.pump(0.5)
    console.wait(lambda: "Quit" in console.text, 20.0, "the picture is over the list")
    console.type("\x1b")
    console.wait(lambda: "What shall be done?" not in console.text, 20.0, "the list stays")


@pytest.mark.parametrize(
    "event",
    [other_sizes, suspend, stop_reading, *in_soak(stop_reading_for_a_minute), open_the_list],
)
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
    console.quit()
    assert told.read_text().splitlines()[-1] == "0"


def test_ctrl_z_and_bg_leave_a_console_that_goes_on_as_soon_as_it_is_in_front(
    hub: HubProcess, start_console: Callable[..., ConsoleProcess], tmp_path: Path
) -> None:
    back, front = tmp_path / "back", tmp_path / "front"
    job = f'set -m; "$@"; bg; touch {back}; until test -e {front}; do sleep 0.05; done; fg'
    console = start_console(hub.endpoint, within=["bash", "-c", job, "bash"])
    before = settled(console)
    (process,) = psutil.Process(console.process.pid).children()
    console.type("\x1a")
    console.wait(back.exists, 20.0, "it is not suspended")
    console.wait(lambda: process.status() == psutil.STATUS_STOPPED, 20.0, "it does not wait")
    front.touch()
    console.wait(lambda: picture(console) == before, 20.0, "the picture is another one")
    assert console.quit() == 0


def test_ctrl_z_does_nothing_where_no_shell_would_have_the_console_go_on(
    console: ConsoleProcess,
) -> None:
    def told() -> bool:
        """Typed while the machine holds up the console, it does not count."""
        console.type("\x1a")
        console.pump(0.5)
        return "Ctrl-Z does nothing here" in console.text

    console.wait(told, 20.0, "it says nothing")


DELAY_S = 1.5
"""Commands come 5 times a second at least; nobody may wait this long for one [s]."""


class ConsoleInTmux(ConsoleProcess):
    """Keys come to it whether or not anybody is attached."""

    first_repeat = 0.55
    """In tmux a press is proven later than elsewhere, see docs/safety.md [s]."""

    def __init__(self, tmux: Sequence[str], layout: Path) -> None:
        self._tmux = tmux
        super().__init__(["run", str(layout)], within=[*tmux, "new"])

    def type(self, keys: str) -> None:
        subprocess.run([*self._tmux, "send-keys", "-l", keys], check=True)


@pytest.fixture
def tmux() -> Iterator[list[str]]:
    """A tmux with no settings and a server of its own."""
    program = shutil.which("tmux")
    if program is None:
        pytest.skip("NOT TESTED: there is no tmux here; apt-get install tmux")
    with tempfile.TemporaryDirectory() as folder:
        own = [program, "-S", f"{folder}/tmux", "-f", os.devnull, "-T", "RGB"]
        yield own
        subprocess.run([*own, "kill-server"], capture_output=True, check=False)


@pytest.mark.soak
def test_the_picture_is_right_and_no_command_late_after_tmux_was_left_and_attached_again(
    hub: HubProcess,
    tmux: list[str],
    start_console: Callable[..., ConsoleProcess],
    tmp_path: Path,
    stack: ExitStack,
) -> None:
    layout = tmp_path / "in_tmux.xml"
    layout.write_text(LAYOUT.format(hub=hub.endpoint))
    console = stack.enter_context(closing(ConsoleInTmux(tmux, layout)))
    console.wait_for_picture()
    console.wait(lambda: "STANDING" in console.text, 10.0)
    observer = stack.enter_context(closing(Observer(hub.endpoint, VELOCITY_COMMAND)))
    commands = observer.seen[VELOCITY_COMMAND.name]
    ends: list[TerminalProcess] = [console]

    def detach() -> None:
        subprocess.run([*tmux, "detach-client"], check=True)

    def attach() -> None:
        assert console.process.poll() is not None, "it is still attached"
        command = [*tmux, "attach"]
        other = TerminalProcess(command, columns=80, rows=24)
        ends.append(stack.enter_context(closing(other)))

    def told() -> bool:
        """Whether all has been done, each after so many more commands to turn."""
        nonlocal seen
        ends[-1].pump(0.01)
        observer.client.listen(0.01)
        count, act = stages[0]
        if sum(command.twist.angular.z != 0.0 for _, command in [*commands][seen:]) < count:
            return False
        act()
        stages.popleft()
        seen = len(commands)
        return not stages

    seen = len(commands)
    stages = deque([(5, detach), (15, attach), (5, lambda: None)])
    console.hold_until("a", told)
    again = ends[-1]
    times = [sent for sent, _ in commands]
    assert max(b - a for a, b in itertools.pairwise(times)) < DELAY_S
    again.wait(lambda: "STANDING" in again.text, 10.0, "the robot does not stand")
    # tmux has the last row.
    plain = start_console(hub.endpoint, columns=80, rows=23)
    plain.wait(lambda: "STANDING" in plain.text, 10.0)
    # Words about who has control come and go.
    until(
        lambda: plain.has_picture and picture(again) == picture(plain),
        20.0,
        lambda: f"the picture is another one\n{again.text}\n{plain.text}",
        meanwhile=lambda: (again.pump(0.03), plain.pump(0.03)),
    )
