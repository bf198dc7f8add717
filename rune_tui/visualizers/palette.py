"""The colours of all visualizers; whatever a colour says is also said by a word or a mark.

The warning colours are orange and white on red: blue against orange stays distinct for people who
do not tell red from green.
"""

from __future__ import annotations

from typing import Final

from rune_tui.raster.canvas import Colour

WHITE: Final[Colour] = (240, 240, 240, 255)
BLACK: Final[Colour] = (0, 0, 0, 255)
PANEL: Final[Colour] = (24, 28, 34, 255)
WARNING: Final[Colour] = (255, 176, 0, 255)
ALARM: Final[Colour] = (200, 24, 24, 255)
ALARM_INK: Final[Colour] = (255, 120, 110, 255)
GOOD_INK: Final[Colour] = (120, 200, 255, 255)
