"""Commands in shell blocks of pages are understood; `test_docs.py` runs those of console blocks."""

from __future__ import annotations

import itertools
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.cli import command_parser
from hub.inspection.adopt_options import with_kind
from rune_tui.commands.arguments import parser

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]


def commands(page: Path) -> Iterator[str]:
    """Lines of the page's shell blocks that call Rune."""
    for block in re.findall(r"^```sh\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE):
        lines = block.replace("\\\n", " ").splitlines()
        yield from (line for line in lines if line.startswith(("rune ", "rune-hub ")))


EVERY = sorted({command for page in PAGES for command in commands(page)})


def test_there_are_commands() -> None:
    assert len(EVERY) > 30


@pytest.mark.parametrize("command", EVERY)
def test_a_command_of_a_shell_block_is_understood(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    split = shlex.shlex(command, posix=True, punctuation_chars="|>")
    split.whitespace_split = True
    program, *words = itertools.takewhile(lambda word: word[0] not in "|>", split)
    try:
        if program == "rune":
            parser().parse_args(words)
        else:
            command_parser().parse_args(with_kind(words))
    except SystemExit:
        pytest.fail(capsys.readouterr().err)
