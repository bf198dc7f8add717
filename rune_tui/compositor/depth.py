"""How many colours a terminal has."""

from __future__ import annotations

import enum


class ColourDepth(enum.Enum):
    """The colours that a terminal can show; the values are what `--colors` takes."""

    TRUECOLOUR = "truecolor"
    """Red, green and blue of eight bits each."""
    INDEXED_256 = "256"
    """The xterm cube of 6 x 6 x 6 and its 24 greys; not the 16 colours that people choose."""
    INDEXED_16 = "16"
    """The 16 of ANSI and aixterm, as the VGA palette and so the Linux console has them."""
    MONO = "mono"
    """No colours: the terminal's own ink and ground, and the two exchanged."""
