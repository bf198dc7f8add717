"""Text that no hand typed: pasted with and without brackets, or what remains of a mutilated key."""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import time
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from tests.system.harness import ConsoleProcess, HubProcess, Observer, drive

ADDRESS = "https://example.org/w"
"""It takes control, gives it up, drives, explores and quits where each character is a key."""
IGNORED = "pasted text presses no keys"


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


def place(observer: Observer) -> tuple[float, float, float]:
    truth = observer.truth
    return truth.x, truth.y, truth.theta


def test_text_that_is_pasted_in_any_way_presses_no_key_and_keys_drive_afterwards(
    hub: HubProcess, stack: ExitStack
) -> None:
    observer = stack.enter_context(closing(Observer(hub.endpoint)))
    command = ["run", "search", "--hub", hub.endpoint]
    console = stack.enter_context(closing(ConsoleProcess(command, columns=170, rows=45)))
    console.wait_for_picture()
    console.wait(lambda: "nobody has control" in console.text, 20.0)
    stands = place(observer)
    pastes = [
        [ADDRESS],
        [f"\x1b[200~{ADDRESS}\x1b[201~"],
        [f"\x1b[200~{ADDRESS}", ADDRESS],
        list(ADDRESS),
        [10 * f"{ADDRESS}\r\n\t"],
        ["\x1b[1;5\x02", *ADDRESS],
    ]
    for pieces in pastes:
        for piece in pieces:
            console.type(piece)
            time.sleep(0.001)  # as of a serial line
        console.type("\x05")
        quiet = time.monotonic() + 2.5
        while time.monotonic() < quiet:
            console.pump()
            observer.client.listen(0.01)
        assert "nobody has control" in console.text, pieces
        assert console.process.poll() is None
        assert place(observer) == stands, pieces
    assert IGNORED in console.text
    drive(console, observer)


def test_a_paste_of_tmux_without_brackets_presses_no_key(
    hub: HubProcess, stack: ExitStack, tmp_path: Path
) -> None:
    program = shutil.which("tmux")
    if program is None:
        pytest.skip("NOT TESTED: there is no tmux here; apt-get install tmux")
    tmux = [program, "-S", str(tmp_path / "tmux"), "-f", os.devnull]
    observer = stack.enter_context(closing(Observer(hub.endpoint)))
    console = stack.enter_context(
        closing(
            ConsoleProcess(
                ["run", "search", "--hub", hub.endpoint],
                columns=170,
                rows=45,
                environment={"TMUX": ""},
                within=[*tmux, "new"],
            )
        )
    )
    stack.callback(subprocess.run, [*tmux, "kill-server"], capture_output=True, check=False)
    console.wait_for_picture()
    console.wait(lambda: "nobody has control" in console.text, 20.0)
    stands = place(observer)
    subprocess.run([*tmux, "set-buffer", ADDRESS], check=True)
    for brackets, _ in itertools.product([["-p"], []], range(2)):
        subprocess.run([*tmux, "paste-buffer", *brackets], check=True)
        console.wait(lambda: IGNORED in console.text, 10.0)
        observer.client.listen(0.5)
        assert "nobody has control" in console.text
        assert place(observer) == stands
