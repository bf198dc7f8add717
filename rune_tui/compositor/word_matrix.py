"""Bytes for cells, many at once: a matrix of words of four bytes, one token of SGR each.

Tokens are padded with zero bytes, and what is left out is zero words; one `bytes.translate` takes
all of them away. It is the fastest way that numpy has, and does not slow down with the number of
colours.
"""

from __future__ import annotations

import numpy as np

from rune_tui.compositor.looks import Flags, Numbers, unpacked
from rune_tui.compositor.planes import Planes
from rune_tui.compositor.sgr import NO_COLOUR, Form, Words


class WordMatrix:
    """Writes cells in groups, each behind a lead; keeps its memory between frames of one size."""

    def __init__(self) -> None:
        self._room: Words = np.zeros(0, np.uint32)

    def joined(self, planes: Planes, form: Form, leads: Words, *, anew: bool) -> bytes:
        """The cells as bytes; colours are told where they are not in force already.

        Args:
            planes: What is written, of shape (groups, cells in a group), at least one cell.
            form: How.
            leads: What stands before each group, shape (groups, words).
            anew: Whether the terminal's attributes are reset before every group; else they are
                before the first, and stay in force over the leads.
        """
        groups, count = planes.marks.shape
        lead, length = leads.shape[1], len(form.cell)
        size = groups * (lead + count * length)
        if len(self._room) < size:
            self._room = np.zeros(size, np.uint32)
        words = self._room[:size]
        buffer = words.reshape(groups, -1)
        buffer[:, :lead] = leads
        # Every word of every cell is written below, if only with zero. Copying several words as
        # one item is several times faster than copying words.
        cell = buffer[:, lead:].reshape(groups, count, length)
        starts = np.arange(0, groups * count, count) if anew else np.zeros(1, np.intp)
        ground = _new(planes.background, planes.ground_shows, starts, form.at_start)
        ink = np.zeros_like(ground)
        if form.foreground.stop:
            ink = _new(planes.foreground, planes.ink_shows, starts, NO_COLOUR)
        item = f"V{4 * length}"
        cell.view(item)[..., 0] = form.outlines.view(item)[:, 0].take(ink + 2 * ground)
        if form.foreground.stop:
            _tell(cell[..., form.ink :], planes.foreground, form.ink_words, form, ink)
        _tell(cell[..., form.ground :], planes.background, form.ground_words, form, ground)
        cell[..., -1] = planes.marks
        if 2 * np.count_nonzero(words) < len(words):
            words = words[words != 0]
        joined: bytes = words.tobytes().translate(None, b"\0")
        return joined


def _new(colours: Words, shows: Flags, starts: Numbers, at_start: np.uint32) -> Words:
    """1 where a colour must be set, else 0: cells that show none leave the last in force."""
    flat, seen = colours.ravel(), shows.ravel()
    before = np.empty_like(flat)
    before[1:] = flat[:-1]
    before[starts] = at_start
    if not seen.all():
        # Behind cells that show none, the last one that showed one counts, or the start.
        behind = np.flatnonzero(seen[1:] > seen[:-1]) + 1
        telling = np.flatnonzero(seen)
        last = telling[np.searchsorted(telling, behind) - 1]
        start = starts[np.searchsorted(starts, behind, side="right") - 1]
        since_start = (last >= start) & (last < behind)
        before[behind] = np.where(since_start, flat[last], at_start)
    new: Words = ((flat != before) & seen).astype(np.uint32).reshape(colours.shape)
    return new


def _tell(room: Words, colours: Words, words: Words, form: Form, new: Words) -> None:
    """Put the numbers of colours into cells, where they are new.

    Args:
        room: Cells from the first number on, shape (groups, cells, words).
        colours: Of all cells, shape (groups, cells).
        words: What tells each value of a byte.
        form: Which bytes count.
        new: 1 where the colour is told, else 0; shape (groups, cells).
    """
    parts = unpacked(colours)
    if form.numbered:
        np.multiply(words.take(parts[..., 3], mode="clip"), new, out=room[..., 0])
    else:
        told = words.take(parts, mode="clip")
        told *= new[..., None]
        room[..., :3].view("V12")[...] = told[..., :3].view("V12")
