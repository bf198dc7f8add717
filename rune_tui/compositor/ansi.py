"""Rows of cells to terminal bytes, each complete in itself; what draws whole rows takes these."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.looks import Numbers, looks_of
from rune_tui.compositor.planes import planes_of
from rune_tui.compositor.sgr import FORMS, RESET, words
from rune_tui.compositor.word_matrix import WordMatrix

_RESET, _NEXT = words([RESET, b"\n"])


class RowEncoder:
    """Turns cells into rows of bytes; keeps its buffers between frames of the same size.

    A row begins and ends with the terminal's attributes reset, does not move the cursor, and takes
    exactly as many cells as the frame has columns.
    """

    def __init__(self) -> None:
        self._matrix = WordMatrix()

    def encode(self, cells: Cells, numbers: Numbers | Sequence[int] | None = None) -> list[bytes]:
        """One piece of bytes a row, UTF-8.

        Args:
            cells: The frame.
            numbers: Which rows, in this order; None for all.
        """
        return self._joined(cells, numbers).split(b"\n")[:-1]

    def encode_text(
        self, cells: Cells, numbers: Numbers | Sequence[int] | None = None
    ) -> list[str]:
        """The rows of `encode` as strings."""
        return self._joined(cells, numbers).decode().split("\n")[:-1]

    def _joined(self, cells: Cells, numbers: Numbers | Sequence[int] | None) -> bytes:
        """All rows, each ended by a line feed, which no cell can hold."""
        form = FORMS[cells.depth]
        planes = planes_of(looks_of(cells, numbers), form)
        rows, columns = (int(length) for length in planes.marks.shape)
        if not rows or not columns:
            return (RESET + b"\n") * rows
        ends = np.zeros((rows + 1, 2), np.uint32)
        ends[1:, 0] = np.where(planes.background[:, -1] != form.at_start, _RESET, 0)
        ends[1:, 1] = _NEXT
        last: bytes = ends[-1].tobytes().translate(None, b"\0")
        return self._matrix.joined(planes, form, ends[:-1], anew=True) + last


def changed_rows(previous: Cells | None, current: Cells) -> Numbers:
    """Numbers of the rows that look different, all when there was no frame of the same kind."""
    if (
        previous is None
        or previous.depth is not current.depth
        or previous.glyphs.shape != current.glyphs.shape
    ):
        return np.arange(current.rows)
    return np.flatnonzero(looks_of(previous).differs(looks_of(current)).any(axis=1))
