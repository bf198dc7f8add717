"""Encodes many cells at once: a matrix of words of four bytes, one SGR token each.

Tokens are padded with zero bytes, and left-out tokens are zero words; one `bytes.translate`
deletes them. This is the fastest way in numpy, and its time does not grow with the colours.
"""

from __future__ import annotations

import numpy as np

from rune_tui.compositor.looks import Flags, Numbers, unpacked
from rune_tui.compositor.planes import Planes
from rune_tui.compositor.sgr import NO_COLOUR, Form, Words


class WordMatrix:
    """Writes groups of cells, each after a lead; reuses its memory for frames of one size."""

    def __init__(self) -> None:
        self._room: Words = np.zeros(0, np.uint32)

    def joined(self, planes: Planes, form: Form, leads: Words, *, reset: bool) -> bytes:
        """The cells as bytes; a colour is set only where it changes.

        Args:
            planes: Characters and colours, shape (groups, cells in a group), at least one cell.
            form: Encoding of their depth.
            leads: Words before each group, shape (groups, words).
            reset: Whether each lead resets the attributes; else the attributes are reset before the
                first group only.
        """
        groups, count = planes.marks.shape
        lead, length = leads.shape[1], len(form.cell)
        size = groups * (lead + count * length)
        if len(self._room) < size:
            self._room = np.zeros(size, np.uint32)
        words = self._room[:size]
        buffer = words.reshape(groups, -1)
        buffer[:, :lead] = leads
        # The code below writes every word of every cell. A copy of several words as one item is
        # several times faster than a copy word by word.
        cell = buffer[:, lead:].reshape(groups, count, length)
        starts = np.arange(0, groups * count, count) if reset else np.zeros(1, np.intp)
        ground = _new(planes.background, planes.ground_shows, starts, form.at_start)
        ink = np.zeros_like(ground)
        if form.foreground.stop:
            ink = _new(planes.foreground, planes.ink_shows, starts, NO_COLOUR)
        item = f"V{4 * length}"
        cell.view(item)[..., 0] = form.outlines.view(item)[:, 0].take(ink + 2 * ground)
        if form.foreground.stop:
            _set_colours(cell[..., form.ink :], planes.foreground, form.ink_words, form, ink)
        _set_colours(cell[..., form.ground :], planes.background, form.ground_words, form, ground)
        cell[..., -1] = planes.marks
        if 2 * np.count_nonzero(words) < len(words):
            words = words[words != 0]
        joined: bytes = words.tobytes().translate(None, b"\0")
        return joined


def _new(colours: Words, shows: Flags, starts: Numbers, at_start: np.uint32) -> Words:
    """1 where a colour must be set, else 0; cells that do not show it leave it unchanged."""
    flat, seen = colours.ravel(), shows.ravel()
    before = np.empty_like(flat)
    before[1:] = flat[:-1]
    before[starts] = at_start
    if not seen.all():
        # After cells that do not show it, the last one that did counts, or the start.
        behind = np.flatnonzero(seen[1:] > seen[:-1]) + 1
        visible = np.flatnonzero(seen)
        last = visible[np.searchsorted(visible, behind) - 1]
        start = starts[np.searchsorted(starts, behind, side="right") - 1]
        since_start = (last >= start) & (last < behind)
        before[behind] = np.where(since_start, flat[last], at_start)
    new: Words = ((flat != before) & seen).astype(np.uint32).reshape(colours.shape)
    return new


def _set_colours(room: Words, colours: Words, words: Words, form: Form, new: Words) -> None:
    """Put the codes of changed colours into cells.

    Args:
        room: Words of cells from the first value on, shape (groups, cells, words).
        colours: Colours of all cells, shape (groups, cells).
        words: Word of each value of a byte.
        form: Encoding, which gives the used bytes.
        new: 1 where the colour is set, else 0; shape (groups, cells).
    """
    parts = unpacked(colours)
    if form.numbered:
        np.multiply(words.take(parts[..., 3], mode="clip"), new, out=room[..., 0])
    else:
        codes = words.take(parts, mode="clip")
        codes *= new[..., None]
        room[..., :3].view("V12")[...] = codes[..., :3].view("V12")
