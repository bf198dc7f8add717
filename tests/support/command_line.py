"""`rune` and `rune-hub`, as a person types them: what they say and how they end."""

from __future__ import annotations

import contextlib
import gc
import io
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

import hub.cli
import rune_tui.cli
from tests.support import warm_start


def run(module: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`python -m module ...` with nothing on its standard input, until it ends by itself."""
    done = warm_start.run([sys.executable, "-m", module, *arguments])
    assert "Traceback" not in done.stderr
    return done


def rune_hub(*arguments: str) -> subprocess.CompletedProcess[str]:
    """`rune-hub ...` in this process, because starting another takes most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hub.cli, "start_logging", lambda *_: None)
        patch.setattr(hub.cli, "leave", _interrupted)
        return _ended(hub.cli.main, arguments)


def rune(*arguments: str) -> subprocess.CompletedProcess[str]:
    """`rune ...` in this process, with nothing on its standard input."""
    thresholds = gc.get_threshold()
    with Path(os.devnull).open() as nothing, pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdin", nothing)
        try:
            return _ended(rune_tui.cli.main, arguments)
        finally:
            gc.set_threshold(*thresholds)


def _ended(
    main: Callable[[Sequence[str]], int], arguments: Sequence[str]
) -> subprocess.CompletedProcess[str]:
    said, complained = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
        try:
            code = main(arguments)
        except SystemExit as end:  # of a command that cannot be understood
            code = int(end.code or 0)
    return subprocess.CompletedProcess(arguments, code, said.getvalue(), complained.getvalue())


def _interrupted(_code: int) -> None:
    raise KeyboardInterrupt
