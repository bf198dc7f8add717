"""The terminal of this process, as the options of a command and its own answers describe it."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from typing import TYPE_CHECKING

from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import GlyphSet

if TYPE_CHECKING:
    from rune_tui.terminal.questions import Answers
    from rune_tui.terminal.traits import Traits


def ask_terminal(options: argparse.Namespace) -> tuple[Traits, Answers, float, tuple[int, int]]:
    """The terminal's traits, its answers, their time [s], and its size."""
    from rune_tui.terminal.questions import Answers
    from rune_tui.terminal.traits import traits_of

    answers, took = Answers(), 0.0
    if sys.platform != "win32":
        from rune_tui.terminal.asking import ask_own

        answers, took = ask_own()
    columns, rows = shutil.get_terminal_size()
    depth = ColourDepth(options.colors) if options.colors else None
    glyphs = GlyphSet(options.glyphs) if options.glyphs else None
    traits = traits_of(
        answers, os.environ, (columns, rows), depth=depth, glyphs=glyphs, aspect=options.aspect
    )
    return traits, answers, took, (columns, rows)
