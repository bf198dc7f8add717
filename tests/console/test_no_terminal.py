"""What `rune` says where it cannot show a console."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from rune_tui.cli import main


class Stream(io.StringIO):
    """An output that is a terminal, or is not."""

    def __init__(self, *, terminal: bool) -> None:
        super().__init__()
        self.terminal = terminal

    def isatty(self) -> bool:
        return self.terminal


@pytest.fixture
def streams(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Says which of the three streams are a terminal."""

    def set_to(**terminals: bool) -> None:
        for name in ("stdin", "stdout"):
            monkeypatch.setattr(sys, name, Stream(terminal=terminals.get(name, True)))
        if terminals.get("stderr", True):
            monkeypatch.setattr(sys.stderr, "isatty", lambda: True)

    return set_to


@pytest.mark.parametrize("command", ["run", "demo"])
@pytest.mark.parametrize("missing", ["stdin", "stdout", "stderr"])
def test_a_console_needs_a_terminal_on_all_three_streams(
    command: str, missing: str, streams: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    streams(**{missing: False})
    assert main([command, "minimal"]) is ExitCode.USAGE
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "needs a terminal" in said


@pytest.mark.parametrize("command", ["run", "demo", "joytest"])
def test_without_a_terminal_the_mistakes_of_a_layout_come_first(
    command: str, streams: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    streams(stdin=False)
    wrong = Path(__file__).parents[1] / "system" / "wrong_layout.xml"
    assert main([command, str(wrong)]) is ExitCode.USAGE
    said = capsys.readouterr().err
    assert f"{wrong}:4:" in said
    assert "needs a terminal" not in said


@pytest.mark.parametrize("command", ["run", "demo"])
def test_a_terminal_that_draws_nothing_is_refused(
    command: str,
    streams: Callable[..., None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    streams()
    monkeypatch.setenv("TERM", "dumb")
    assert main([command, "minimal"]) is ExitCode.USAGE
    assert "TERM is dumb" in capsys.readouterr().err
