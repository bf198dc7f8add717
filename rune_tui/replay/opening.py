"""Opens recordings for `rune replay`, and writes pictures of them."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from rune_tui.compositor.picture import PictureFile
from rune_tui.errors import LogError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.replay import screen
from rune_tui.replay.console_log import ConsoleLog
from rune_tui.replay.desk import Desk, entered
from rune_tui.replay.player import Player
from rune_tui.replay.source import ReplaySource


def open_source(files: Sequence[Path], layout: LayoutSpec | None) -> ReplaySource:
    """The recordings of some files as one source.

    Args:
        files: The files.
        layout: A layout that shows them; None: the recorded one.

    Raises:
        RecordingError: A file cannot be read.
        LogError: There is nothing in them that can be shown.
    """
    (first,) = files
    return ConsoleLog(first, layout)


def start_of(text: str) -> int:
    """The time after the begin that a text means [ns].

    Raises:
        LogError: It is no time.
    """
    found = entered(text, 0)
    if found is None:
        reason = f"{text[:40]!r} is no time; 90, 1:30 and 1:02:30 are"
        raise LogError(reason)
    return found


def player_of(opened: Callable[[], ReplaySource], options: Namespace) -> Player:
    """A player at the time, with the rate and the loop of the command line."""
    start = start_of(options.start)
    player = Player(opened, rate=options.rate, loop=options.loop)
    player.seek(player.source.start + start)
    player.playing = True
    return player


def export(opened: Callable[[], ReplaySource], start: int, path: Path, *, as_seen: bool) -> None:
    """Write the picture at a time into a file.

    Args:
        opened: Opens the recording.
        start: The time after its begin [ns].
        path: The file.
        as_seen: Whether to leave out the border that says that it is a recording.

    Raises:
        PictureFileError: The file cannot be written.
        LogError: There is no picture.
    """
    file = PictureFile(path)
    with closing(Player(opened)) as player:
        cells = player.seek(player.source.start + start, whole=True)
        if cells is None:
            reason = f"{player.source.title} has no frame there"
            raise LogError(reason)
        if not as_seen:
            columns, rows = cells.columns + 2 * screen.SIDES, cells.rows
            cells = Desk(player, lambda: 0.0).cells(columns, rows + screen.TOP + screen.BOTTOM)
        file.write(file.draw(cells, ()))
