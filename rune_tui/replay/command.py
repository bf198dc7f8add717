"""`rune replay` on a terminal."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from rune_tui.replay.app import ReplayApp
from rune_tui.replay.clip_writer import ClipWriter
from rune_tui.replay.opening import player_of
from rune_tui.replay.review_notes import ReviewNotes
from rune_tui.replay.source import ReplaySource
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import Traits


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
        traits, answers, took = ask_terminal()
        trip = took if answers.complete else 0.0
        ReplayApp(player, traits, trip, notes=ReviewNotes(first), clips=clips).run()
        return [*player.source.faults]
