"""`rune replay --export`: pictures and videos of recordings."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from hub import files
from hub.plain_text import plain
from rune_tui.compositor.picture import PictureFile
from rune_tui.errors import LogError, PictureFileError
from rune_tui.replay import screen
from rune_tui.replay.clip import SUFFIXES, ClipOptions, write_clip
from rune_tui.replay.desk import Desk
from rune_tui.replay.mission_page import mission_page
from rune_tui.replay.opening import start_of
from rune_tui.replay.player import Player
from rune_tui.replay.source import ReplaySource


def export(options: Namespace, opened: Callable[[], ReplaySource]) -> None:
    """Write what the command line asks for; the suffix of the file gives the format.

    Args:
        options: Those of `rune replay`.
        opened: Opens the recording.

    Raises:
        LogError: There is nothing to show in this part.
        PictureFileError: The file cannot be written, or PyAV is missing.
    """
    start, path = start_of(options.start), options.export
    if path.suffix.lower() == ".html":
        with closing(Player(opened)) as player:
            page = mission_page(player, _progress(f"writing {path.name}"))
        _write(path, page)
        return
    if path.suffix.lower() not in SUFFIXES:
        export_picture(opened, start, path, as_seen=options.as_seen)
        return
    clip = ClipOptions(
        start=start,
        end=start_of(options.end) if options.end is not None else None,
        rate=options.rate,
        frames_per_s=options.fps,
        scale=options.scale,
        as_seen=options.as_seen,
        lossless=options.lossless,
    )
    with closing(Player(opened)) as player:
        write_clip(player, path, clip, _progress(f"writing {path.name}"))


def _write(path: Path, text: str) -> None:
    try:
        files.replace(path, text.encode())
    except OSError as error:
        reason = f"{path} cannot be written: {error.strerror or error}; choose another place"
        raise PictureFileError(reason) from error


def export_picture(
    opened: Callable[[], ReplaySource], start: int, path: Path, *, as_seen: bool
) -> None:
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
            why = f": {faults[-1]}" if (faults := player.source.faults) else ""
            reason = f"{player.source.title} has no frame there{why}"
            raise LogError(reason)
        if not as_seen:
            columns, rows = cells.columns + 2 * screen.SIDES, cells.rows
            cells = Desk(player, lambda: 0.0).cells(columns, rows + screen.TOP + screen.BOTTOM)
        file.write(file.draw(cells, ()))


def _progress(words: str) -> Callable[[float], None]:
    """Shows the share that is done, 0 to 1, where a person sees it."""
    shown = -1

    def show(share: float) -> None:
        nonlocal shown
        percent = int(100 * share)
        if percent != shown and sys.stderr.isatty():
            shown = percent
            sys.stderr.write(f"\r{plain(words)}: {percent} %" + ("\n" if share >= 1 else ""))
            sys.stderr.flush()

    return show
