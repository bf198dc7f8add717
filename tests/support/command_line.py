"""`rune` and `rune-hub`, as a person types them: what they say and how they end."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys

import pytest

from hub import cli


def run(module: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`python -m module ...` with nothing on its standard input, until it ends by itself."""
    command = [sys.executable, "-m", module, *arguments]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=30.0,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    assert "Traceback" not in done.stderr
    return done


def rune_hub(*arguments: str) -> subprocess.CompletedProcess[str]:
    """`rune-hub ...` in this process, because starting another takes most of the time."""
    said, complained = io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(complained),
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setattr(cli, "start_logging", lambda *_: None)
        patch.setattr(cli, "_leave", _interrupted)
        try:
            code = cli.main(arguments)
        except SystemExit as end:  # of a command that cannot be understood
            code = int(end.code or 0)
    return subprocess.CompletedProcess(arguments, code, said.getvalue(), complained.getvalue())


def _interrupted() -> None:
    raise KeyboardInterrupt
