"""`rune replay --export`: pictures and videos of recordings."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from hub import files
from hub.plain_text import plain
from hub.recording.holes import said_of_holes
from rune_tui.compositor.picture import SUFFIXES as PICTURES
from rune_tui.compositor.picture import PictureFile
from rune_tui.errors import LogError, PictureFileError
from rune_tui.replay import screen
from rune_tui.replay.clip import SUFFIXES as CLIPS
from rune_tui.replay.clip import ClipOptions, write_clip
from rune_tui.replay.desk import Desk
from rune_tui.replay.mission_page import mission_page
from rune_tui.replay.opening import moment_of
from rune_tui.replay.player import Player
from rune_tui.replay.review_notes import ReviewNotes
from rune_tui.replay.source import ReplaySource, with_notes

_PAGE = ".html"
_CHECK_S = 2.0
"""Longest time to look for damage in parts that the export does not show [s]."""


def export(options: Namespace, opened: Callable[[], ReplaySource]) -> list[str]:
    """Write what the command line asks for; the suffix of the file gives the format.

    Args:
        options: Those of `rune replay`.
        opened: Opens the recording.

    Returns:
        What of the recording cannot be shown, in sentences.

    Raises:
        LogError: There is nothing to show in this part, or a time is none of the recording.
        PictureFileError: The file exists or cannot be written, or PyAV is missing.
    """
    path: Path = options.export
    suffix = path.suffix.lower()
    if suffix not in (*PICTURES, *CLIPS, _PAGE):
        *most, last = *PICTURES, *CLIPS, _PAGE
        text = f"{path}: the name of an export ends in {', '.join(most)} or {last}; name it so"
        raise PictureFileError(text)
    if path.exists() and not options.force:
        text = f"{path} exists; choose another name, or replace it with --force"
        raise PictureFileError(text)
    with closing(Player(opened)) as player:
        source = player.source
        start = moment_of(options.start, source)
        source.check(_CHECK_S)
        faults: list[str] = []
        end = moment_of(options.end, source) if options.end is not None else source.end
        if suffix == _PAGE:
            notes = ReviewNotes(options.files[0])
            faults = [notes.fault] if notes.fault else []
            page = mission_page(player, _progress(f"writing {path.name}"), notes.events)
            _write(path, page)
        elif suffix in PICTURES:
            _export_picture(player, start, path, options)
        else:
            clip = ClipOptions(
                start=start - source.start,
                end=end - source.start,
                rate=options.rate,
                frames_per_s=options.fps,
                scale=options.scale,
                as_seen=options.as_seen,
                lossless=options.lossless,
            )
            write_clip(player, path, clip, _progress(f"writing {path.name}"))
        return [*source.faults, *said_of_holes(source.holes), *faults]


def _write(path: Path, text: str) -> None:
    try:
        files.write_output(path, text.encode())
    except OSError as error:
        reason = f"{path} cannot be written: {error.strerror or error}; choose another place"
        raise PictureFileError(reason) from error


def _export_picture(player: Player, stamp: int, path: Path, options: Namespace) -> None:
    file = PictureFile(path)
    cells = player.seek(stamp, whole=True)
    if cells is None:
        why = f": {faults[-1]}" if (faults := player.source.faults) else ""
        reason = f"{player.source.title} has no frame there{why}"
        raise LogError(reason)
    if not options.as_seen:
        columns, rows = cells.columns + 2 * screen.SIDES, cells.rows
        desk = Desk(player, lambda: 0.0)
        desk.overview = with_notes(player.survey(), ReviewNotes(options.files[0]).events)
        cells = desk.cells(columns, rows + screen.TOP + screen.BOTTOM)
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
