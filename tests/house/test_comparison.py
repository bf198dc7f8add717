"""Every row of the comparison ends with a command of ours that exists."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import hub.cli
import rune_tui.commands.arguments
from rune_tui.startup.opening import open_layout
from tests.support.cases import for_each

ROOT = Path(__file__).parents[2]
ROWS = [
    line.strip("| \n").split(" | ")
    for line in (ROOT / "docs" / "comparison.md").read_text().splitlines()
    if line.startswith("| ") and not line.startswith(("| ---", "| | "))
]
COMMANDS = sorted({row[-1].strip("`") for row in ROWS})


def test_every_row_says_something_of_everyone_and_ends_with_a_command() -> None:
    assert len(ROWS) > 20
    assert {len(row) for row in ROWS} == {7}
    assert all(re.fullmatch(r"`[^`]+`", row[-1]) for row in ROWS)


@for_each("command", COMMANDS)
def test_a_command_is_one_that_there_is(command: str) -> None:
    program, *arguments = shlex.split(command)
    if program == "rune":
        options = rune_tui.commands.arguments.parser().parse_args(arguments)
        for layout in [getattr(options, "layout", None), *getattr(options, "layouts", [])]:
            if isinstance(layout, str) and "bad_layouts" not in layout:
                open_layout(ROOT / layout if "/" in layout else layout)
    elif program == "rune-hub":
        if "--help" not in arguments:
            hub.cli.command_parser().parse_args(arguments)
    elif program == "python":
        flag, module = arguments
        assert flag == "-m"
        assert (ROOT / (module.replace(".", "/") + ".py")).is_file()
    else:
        assert program == "pytest"
        assert (ROOT / arguments[-1]).exists()


def test_what_others_do_better_is_not_what_rune_does_too() -> None:
    """A feature that has a row of ours is not denied below the rows."""
    page = (ROOT / "docs" / "comparison.md").read_text()
    below = page.partition("## What the others do better")[2]
    denied = re.findall(r"replays nothing|needs a bridge|shows none|speaks its own", below)
    assert denied == []
    ours = {row[0]: row[5] for row in ROWS}
    for feature in ("replay of recordings", "point clouds", "robots with ROS"):
        assert ours[feature].startswith(("yes", "part"))
