"""How exactly a picture is sent to the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """How far a colour on the terminal may be from the one that was drawn.

    No channel of a pixel is ever further off than the larger of the two. In a cell of quadrants,
    that counts for each quarter, from the one of the cell's two colours that it has at the best
    quality. Characters, their ink and what is behind them are exact at every quality, and so is
    everything where a terminal numbers its colours: what is saved there would be seen.

    Attributes:
        tolerance: Neighbouring pixels become one colour if that changes no channel by more, 0 to
            127. It makes fewer bytes of each cell that is sent.
        threshold: Pixels stay as the terminal shows them while no channel is further off than
            this, 0 to 255. It makes fewer cells to send; two more than the tolerance keeps the
            noise of a camera from the line.
    """

    tolerance: int = 0
    threshold: int = 0

    def __post_init__(self) -> None:
        if not (0 <= self.tolerance <= 127 and 0 <= self.threshold <= 255):
            text = f"{self}: a tolerance is 0 to 127 and a threshold 0 to 255; choose other numbers"
            raise ValueError(text)


EXACT: Final = Quality()
