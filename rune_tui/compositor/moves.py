"""Cursor moves between cells in the order of writing, as words of four bytes."""

from __future__ import annotations

from typing import Final

import numpy as np

from rune_tui.compositor.looks import Numbers
from rune_tui.compositor.sgr import Words, words

_MOVE_WORDS: Final = 5
_ESCAPE, _SEMICOLON, _GO = words([b"\x1b[", b";", b"H"])
_FARTHEST = 999
"""Most columns that fit into a word with the letter that ends the move."""


class Moves:
    """Moves in a frame of one size, at one place on the terminal."""

    def __init__(self, size: tuple[int, ...], *, top: int, left: int) -> None:
        """Prepare.

        Args:
            size: Rows and columns of the frame [cells].
            top: Rows of the terminal above it.
            left: Columns of the terminal left of it.
        """
        rows, columns = size
        self._rows = words([b"%d" % (top + row + 1) for row in range(rows)])
        self._columns = words([b"%d" % (left + column + 1) for column in range(columns)])
        self._row_of, self._column_of = np.divmod(np.arange(rows * columns), max(1, columns))
        steps = range(2, min(columns, _FARTHEST + 1))
        self._steps = words([b"", b"C", *(b"%dC" % step for step in steps)])
        self.to_rows: Words = self.to(np.arange(0, rows * columns, max(1, columns)))
        """Moves to the first cell of each row, shape (rows, 5)."""

    def to(self, numbers: Numbers) -> Words:
        """Moves to each cell from the cell before it; the first move starts anywhere.

        Args:
            numbers: Cell numbers in the order of writing, shape (n,).

        Returns:
            Shape (n, 5).
        """
        rows, columns = self._row_of.take(numbers), self._column_of.take(numbers)
        moves = np.zeros((len(numbers), _MOVE_WORDS), np.uint32)
        steps = np.zeros(len(numbers), np.intp)
        np.subtract(columns[1:], columns[:-1], out=steps[1:])
        steps[1:] -= 1
        jumps = (steps > _FARTHEST) | (steps < 0)
        jumps[:1] = True
        jumps[1:] |= rows[1:] != rows[:-1]
        steps[jumps] = 0
        stepped, jumped = np.flatnonzero(steps), np.flatnonzero(jumps)
        moves[stepped, 0] = _ESCAPE
        moves[stepped, 1] = self._steps[steps[stepped]]
        moves[jumped, 0] = _ESCAPE
        moves[jumped, 1] = self._rows[rows[jumped]]
        moves[jumped, 2] = _SEMICOLON
        moves[jumped, 3] = self._columns[columns[jumped]]
        moves[jumped, 4] = _GO
        return moves
