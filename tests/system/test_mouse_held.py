"""A button of the mouse that drives, to the wheels: what ends it when the terminal cannot tell."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path

from tests.system.conftest import LAYOUT
from tests.system.harness import STILL, ConsoleProcess, HubProcess, Observer

_DOWN, _UP = "\x1b[<0;20;5M", "\x1b[<0;20;5m"


def test_a_button_drives_no_further_when_the_terminal_falls_silent(
    hub: HubProcess, observer: Observer, tmp_path: Path, stack: ExitStack
) -> None:
    layout = tmp_path / "mouse.xml"
    text = LAYOUT.format(hub=hub.endpoint)
    layout.write_text(text.replace('key="w"', 'mouse="left"'))
    console = stack.enter_context(closing(ConsoleProcess(["run", str(layout)])))
    console.wait_for_picture()
    console.wait(lambda: "STANDING" in console.text, 10.0)
    start = observer.truth.x
    console.type(_DOWN)
    # Where the terminal answers, a hand that holds still drives for as long as it likes.
    observer.wait(lambda: console.pump(0.02) or observer.truth.x - start > 1.0, 20.0)
    # Nothing is read from here on, and nothing answered: the line is cut.
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 4.0, "it drives on")
    assert observer.truth.commanded_linear == 0.0
    console.type(_UP)
