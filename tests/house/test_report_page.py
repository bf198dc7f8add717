"""The page about the report of 2005 names files, tests and commands that exist."""

from __future__ import annotations

import argparse
import ast
import functools
import importlib.util
import re
import shlex
from pathlib import Path

import hub.cli
import rune_tui.commands.arguments
from rune_tui.startup.opening import layout_path
from tests.support.cases import for_each

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "report-2005.md").read_text()
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in PAGE.splitlines()
    if re.match(r"\| \d+ \|", line)
]
FILES = sorted({code for row in ROWS for code in re.findall(r"`([^`]+)`", row[2])})
SHOWN_BY = sorted({code for row in ROWS for code in re.findall(r"`([^`]+)`", row[3])})
TESTS = [shown for shown in SHOWN_BY if shown.startswith("tests/")]
COMMANDS = [shown for shown in SHOWN_BY if not shown.startswith("tests/")]


def test_items_are_numbered_and_the_page_says_how_many_of_each_kind() -> None:
    numbers = [int(row[0]) for row in ROWS]
    assert numbers == list(range(1, len(ROWS) + 1))
    kinds = [int(count) for count in re.findall(r"^\| [a-z][^|]* \| (\d+) \|$", PAGE, re.MULTILINE)]
    assert len(kinds) > 1
    assert sum(kinds[:-1]) == kinds[-1] == len(ROWS)


def test_each_item_is_in_rune_and_shown_or_has_a_reason() -> None:
    assert {len(row) for row in ROWS} == {5}
    assert [row for row in ROWS if not row[3] or not (row[2] or row[4])] == []


@for_each("path", FILES)
def test_a_file_of_the_page_exists(path: str) -> None:
    assert (ROOT / path).exists()


@for_each("test", TESTS)
def test_a_test_of_the_page_exists(test: str) -> None:
    path, _, name = test.partition("::")
    assert (ROOT / path).exists()
    assert not name or name in _functions(ROOT / path)


@for_each("command", COMMANDS)
def test_a_command_of_the_page_is_understood(command: str) -> None:
    program, *arguments = shlex.split(command)
    if program in ("rune", "rune-hub"):
        _parse(program, arguments)
    elif program == "make":
        assert re.search(rf"^{arguments[0]}:", (ROOT / "Makefile").read_text(), re.MULTILINE)
    else:
        assert (program, arguments[0]) == ("python", "-m")
        assert importlib.util.find_spec(arguments[1])


@functools.cache
def _functions(path: Path) -> frozenset[str]:
    tree = ast.parse(path.read_text())
    return frozenset(each.name for each in tree.body if isinstance(each, ast.FunctionDef))


def _parse(program: str, arguments: list[str]) -> None:
    """Have the real parser read a command, and find its layouts."""
    parsers = {"rune": rune_tui.commands.arguments.parser, "rune-hub": hub.cli.command_parser}
    try:
        options = parsers[program]().parse_args(arguments)
    except SystemExit as end:
        assert end.code == 0, "the command is refused"  # noqa: PT017 - 0 is for --help and --version
        return
    for layout in _layouts(options):
        assert (ROOT / layout).is_file() if "/" in layout else layout_path(layout)


def _layouts(options: argparse.Namespace) -> list[str]:
    named = [getattr(options, "layout", None), *getattr(options, "layouts", [])]
    return [each for each in named if isinstance(each, str)]
