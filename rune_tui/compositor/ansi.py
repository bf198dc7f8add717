"""Encodes rows of cells as terminal bytes; each row is complete, without cursor moves."""

from __future__ import annotations

import numpy as np

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.glyph_set import UPPER_HALF
from rune_tui.compositor.looks import Looks, looks_of
from rune_tui.compositor.planes import planes_of
from rune_tui.compositor.sgr import FORMS, RESET, words
from rune_tui.compositor.word_matrix import WordMatrix

_RESET, _NEXT = words([RESET, b"\n"])


def encoded_rows(frame: Cells | Looks, half: str = UPPER_HALF) -> list[str]:
    """Terminal bytes of each row, as text; every row begins and ends with reset attributes.

    Args:
        frame: Cells or their looks.
        half: `UPPER_HALF` or `LOWER_HALF`, as a `ScreenEncoder` takes it.
    """
    looks = frame if isinstance(frame, Looks) else looks_of(frame)
    form = FORMS[looks.depth]
    planes = planes_of(looks, form, half)
    rows, columns = (int(length) for length in planes.marks.shape)
    if not rows or not columns:
        return [RESET.decode()] * rows
    # The lead of a row ends the row before it; no cell can hold a line feed.
    leads = np.zeros((rows, 2), np.uint32)
    ends = planes.background[:, -1] != form.at_start
    leads[1:, 0] = np.where(ends[:-1], _RESET, 0)
    leads[1:, 1] = _NEXT
    joined = WordMatrix().joined(planes, form, leads, reset=True)
    return (joined + RESET if ends[-1] else joined).decode().split("\n")
