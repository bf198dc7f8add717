"""Bytes for cells, many at once: a matrix of words of four bytes, one token of SGR each.

Tokens are padded with zero bytes, and what is left out is zero words; one `bytes.translate` takes
all of them away. It is the fastest way that numpy has, and does not slow down with the number of
colours.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rune_tui.compositor.looks import Flags, Numbers, unpacked
from rune_tui.compositor.planes import Planes
from rune_tui.compositor.sgr import NO_COLOUR, Form, Words


class WordMatrix:
    """Writes cells in groups, each behind a lead; keeps its memory between frames of one size."""

    def __init__(self) -> None:
        self._room: Words = np.zeros(0, np.uint32)
        self._order: Numbers = np.zeros(0, np.intp)

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
        self._make_room(groups * count, groups * (lead + count * length))
        buffer = self._room[: groups * (lead + count * length)].reshape(groups, -1)
        buffer[:, :lead] = leads
        # Every word of every cell is written below, if only with zero.
        cell = buffer[:, lead:].reshape(groups, count, length)
        starts = np.arange(0, groups * count, count) if anew else np.zeros(1, np.intp)
        ground = self._new(planes.background, planes.ground_shows, starts, form.at_start)
        ink = np.zeros_like(ground)
        if form.foreground.stop:
            ink = self._new(planes.foreground, planes.ink_shows, starts, NO_COLOUR)
            _tell(cell[..., form.ink :], planes.foreground, form.ink_words, form, ink)
        _tell(cell[..., form.ground :], planes.background, form.ground_words, form, ground)
        for place, mask in _constants(form, ink, ground):
            np.multiply(mask, form.cell[place], out=cell[..., place])
        cell[..., -1] = planes.marks
        joined: bytes = buffer.tobytes().translate(None, b"\0")
        return joined

    def _make_room(self, cells: int, words: int) -> None:
        if len(self._room) < words:
            self._room = np.zeros(words, np.uint32)
        if len(self._order) < cells:
            self._order = np.arange(cells)

    def _new(self, colours: Words, shows: Flags, starts: Numbers, at_start: np.uint32) -> Words:
        """1 where a colour must be set, else 0: cells that show none leave the last in force."""
        flat, seen = colours.ravel(), shows.ravel()
        before = np.empty_like(flat)
        before[1:] = flat[:-1]
        if not seen.all():
            known = seen.copy()
            known[starts] = True
            last = np.where(known, self._order[: len(flat)], 0)
            np.maximum.accumulate(last, out=last)
            in_force = flat.copy()
            hidden = starts[~seen[starts]]
            in_force[hidden] = at_start
            before[1:] = in_force[last[:-1]]
        before[starts] = at_start
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
        # Four words are copied faster than three; the place of the last is a constant's.
        np.multiply(words.take(parts, mode="clip"), new[..., None], out=room[..., :4])


def _constants(form: Form, ink: Words, ground: Words) -> Iterator[tuple[int, Words]]:
    """The places of a cell's words that are always the same, and 1 where they are written."""
    either, both = ink | ground, ink & ground
    for place in np.flatnonzero(form.cell).tolist():
        in_ink = form.foreground.start <= place < form.foreground.stop
        in_ground = form.background.start <= place < form.background.stop
        if in_ink and in_ground:
            yield place, both
        elif in_ink or in_ground:
            yield place, ink if in_ink else ground
        else:
            yield place, either
