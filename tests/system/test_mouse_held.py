"""A button of the mouse that drives, to the wheels: what ends it when the terminal cannot tell."""

from __future__ import annotations

import time
from contextlib import ExitStack, closing
from pathlib import Path

from tests.support.waiting import Limit
from tests.system.conftest import LAYOUT
from tests.system.harness import STILL, ConsoleProcess, HubProcess, Observer

_DOWN, _UP = "\x1b[<0;20;5M", "\x1b[<0;20;5m"


def _drives(console: ConsoleProcess, observer: Observer) -> bool:
    """Press the button; whether the robot then drives a metre."""
    start, end = observer.truth.x, time.monotonic() + 8.0
    console.type(_DOWN)
    while time.monotonic() < end:
        console.pump(0.02)
        if observer.truth.x - start > 1.0:
            return True
    return False


def test_a_button_drives_no_further_when_the_terminal_falls_silent(
    hub: HubProcess, observer: Observer, tmp_path: Path, stack: ExitStack
) -> None:
    layout = tmp_path / "mouse.xml"
    text = LAYOUT.format(hub=hub.endpoint)
    layout.write_text(text.replace('key="w"', 'mouse="left"'))
    console = stack.enter_context(closing(ConsoleProcess(["run", str(layout)])))
    console.wait_for_picture()
    console.wait(lambda: "STANDING" in console.text, 10.0)
    # Where the terminal answers, a hand that holds still drives for as long as it likes.
    limit = Limit(40.0)
    while not _drives(console, observer):
        assert not limit.over, f"the button does not drive\n{console.text}"
        console.type(_UP)  # a busy console ignored it, or let go: press again, as a person does
        console.pump(1.0)
    # Nothing is read from here on, and nothing answered: the line is cut.
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 4.0, "it drives on")
    assert observer.truth.commanded_linear == 0.0
    console.type(_UP)
