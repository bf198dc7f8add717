"""Exactness of a picture on the terminal."""

from __future__ import annotations

from typing import Final

from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """Largest error of colours on the terminal.

    The error of a channel is at most the larger of the two limits. In a cell of quadrants it counts
    from the quarter's colour at the best quality. Cells with characters are always exact, and so
    are numbered colours.

    Attributes:
        tolerance: Largest change of a channel by merging neighbours, 0 to 127; saves bytes per
            cell.
        threshold: Largest error of a channel for which a cell is not sent again, 0 to 255; saves
            cells. Two more than the tolerance filters a camera's noise.
    """

    tolerance: int = 0
    threshold: int = 0

    def __post_init__(self) -> None:
        if not (0 <= self.tolerance <= 127 and 0 <= self.threshold <= 255):
            text = f"{self}: a tolerance is 0 to 127 and a threshold 0 to 255; choose other numbers"
            raise ValueError(text)


EXACT: Final = Quality()
