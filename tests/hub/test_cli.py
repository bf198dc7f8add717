"""`rune-hub` as a person types it, where it needs no hub."""

from __future__ import annotations

from importlib.metadata import version

from tests.command_line import rune_hub


def test_it_tells_its_version() -> None:
    done = rune_hub("--version")
    assert (done.returncode, done.stdout) == (0, f"rune-hub {version('robot-user-nexus')}\n")
