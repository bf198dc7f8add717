"""Colour depths of terminals."""

from __future__ import annotations

import enum


class ColourDepth(enum.Enum):
    """Colours that a terminal can show; the values are those of `--colors`."""

    TRUECOLOUR = "truecolor"
    """Red, green and blue of eight bits each."""
    INDEXED_256 = "256"
    """The xterm cube of 6 x 6 x 6 and its 24 greys, without the 16 colours of the user's theme."""
    INDEXED_16 = "16"
    """The 16 of ANSI and aixterm, with the VGA palette of the Linux console."""
    MONO = "mono"
    """No colours: the terminal's own ink and ground, and both inverted."""
