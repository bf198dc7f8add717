"""Consoles on terminals with fewer colours, and with the characters that somebody chose."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pyte.graphics
import pytest

from tests.system.conftest import LAYOUT
from tests.system.harness import ConsoleProcess, HubProcess

Start = Callable[..., ConsoleProcess]

XTERM = {*pyte.graphics.FG_BG_256[16:], "default"}
ANSI = {
    *pyte.graphics.FG_ANSI.values(),
    *pyte.graphics.FG_AIXTERM.values(),
    *pyte.graphics.BG_ANSI.values(),
    *pyte.graphics.BG_AIXTERM.values(),
}


@pytest.fixture
def start(lasting_hub: HubProcess, tmp_path: Path) -> Iterator[Start]:
    """A console on a small terminal, with options and with an environment."""
    consoles: list[ConsoleProcess] = []

    def start(*options: str, **environment: str) -> ConsoleProcess:
        layout = tmp_path / "layout.xml"
        layout.write_text(LAYOUT.format(hub=lasting_hub.endpoint))
        arguments = ["run", str(layout), *options]
        console = ConsoleProcess(arguments, columns=60, rows=20, environment=environment)
        consoles.append(console)
        console.wait(lambda: "STANDING" in console.text, 20.0)
        return console

    yield start
    for console in consoles:
        with closing(console):
            pass


def used(console: ConsoleProcess) -> set[str]:
    """All colours on the screen."""
    return {colour for pair in console.colours().values() for colour in pair}


def test_the_option_counts_for_more_than_what_the_environment_says(start: Start) -> None:
    console = start("--colors", "256", NO_COLOR="1")
    console.wait(lambda: len(used(console)) > 8, 20.0, "no picture came")
    assert used(console) <= XTERM


def test_the_linux_console_gets_its_16_colours(start: Start) -> None:
    console = start(TERM="linux", COLORTERM="")
    console.wait(lambda: len(used(console)) > 4, 20.0, "no picture came")
    assert used(console) <= ANSI


def test_with_no_color_set_the_picture_is_made_of_characters(start: Start) -> None:
    console = start(NO_COLOR="1")
    console.wait(lambda: Counter(console.text)["▒"] > 100, 20.0, "no picture came")
    assert used(console) == {"default"}
    assert "m/s" in console.text


def test_pictures_are_made_of_the_characters_that_were_chosen(start: Start) -> None:
    console = start("--glyphs", "lower")
    console.wait(lambda: Counter(console.text)["▄"] > 100, 20.0, "no picture came")
    assert "▀" not in console.text


def test_pictures_of_quadrants_reach_the_terminal(start: Start) -> None:
    console = start("--glyphs", "quadrants")
    console.wait(lambda: sum(map(Counter(console.text).get, "▘▚▌▙▜▛", [0] * 6)) > 30, 20.0)
    assert "m/s" in console.text
