"""`rune replay` on a terminal."""

from __future__ import annotations

import contextlib
import os
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from hub.recording.holes import said_of_holes
from rune_tui.replay.app import ReplayApp
from rune_tui.replay.clip_writer import ClipWriter
from rune_tui.replay.opening import player_of
from rune_tui.replay.review_notes import ReviewNotes
from rune_tui.replay.source import ReplaySource
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import Traits

_RECENT_S = 5.0
"""A file without an end that changed later than this ago is still written [s]."""
_CHECK_S = 0.03
"""Longest time to look for damage before the first picture [s]."""
_END = b"\x89MCAP0\r\n"
"""The last bytes of a complete MCAP file."""


def still_written(paths: Sequence[Path], now: float) -> str:
    """Which recording is still written, in a sentence; empty: none.

    Args:
        paths: The files.
        now: The time [s since 1970].
    """
    for path in paths:
        with contextlib.suppress(OSError):
            if path.suffix != ".mcap" or now - path.stat().st_mtime > _RECENT_S:
                continue
            with path.open("rb") as file:
                file.seek(-min(len(_END), path.stat().st_size), os.SEEK_END)
                if file.read() != _END:
                    return f"{path.name} is still written; open it again to see more"
    return ""


def show(
    options: Namespace,
    opened: Callable[[], ReplaySource],
    ask_terminal: Callable[[], tuple[Traits, Answers, float]],
) -> list[str]:
    """Show a recording until the person ends it.

    Args:
        options: Those of `rune replay`.
        opened: Opens the recording.
        ask_terminal: Finds the abilities of the terminal, its answers, and their time [s].

    Returns:
        What of the recording cannot be shown, in sentences.

    Raises:
        LogError: A time is none of the recording.
    """
    first: Path = options.files[0]
    with (
        closing(player_of(opened, options)) as player,
        closing(ClipWriter(opened, first)) as clips,
    ):
        growing = still_written(options.files, time.time())
        player.source.check(_CHECK_S)
        holes = said_of_holes(player.source.holes)
        damage = next(iter((*player.source.faults, *holes)), "")
        traits, answers, took = ask_terminal()
        trip = took if answers.complete else 0.0
        app = ReplayApp(player, traits, trip, notes=ReviewNotes(first), clips=clips)
        if growing or damage:
            app.desk.say(growing or damage)
        app.run()
        return [*player.source.faults, *holes]
