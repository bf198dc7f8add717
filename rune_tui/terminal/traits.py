"""The assumed abilities of the terminal, with reasons."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Final

from hub.values import dataclass
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.terminal.questions import Answers

USUAL_ASPECT: Final = 2.0
"""Default height of a cell over its width."""
_ASPECTS: Final = (1.0, 4.0)
"""Possible values of a font; others count as a fault."""
_REPORTED: Final = "the terminal says so"
_GIVEN: Final = "the command line says so"
_SILENT: Final = "the terminal does not say"


@dataclass(frozen=True, slots=True, kw_only=True)
class Traits:
    """The abilities of the terminal.

    Attributes:
        depth: Its colours.
        glyphs: The glyphs of pictures; `GlyphSet.HALF` where the colours leave no choice.
        aspect: Height of a cell over its width.
        synchronized: Whether it shows a frame all at once.
        acknowledges: Whether it reports that it shows a frame.
        releases: Whether it can report the release of a key.
        discards: Whether it drops output that is too much for its own terminal.
        reasons: Why each is so, by its name.
    """

    depth: ColourDepth
    glyphs: GlyphSet
    aspect: float
    synchronized: bool
    acknowledges: bool
    releases: bool
    discards: bool
    reasons: Mapping[str, str]


def traits_of(
    answers: Answers,
    environment: Mapping[str, str],
    size: tuple[int, int],
    *,
    depth: ColourDepth | None = None,
    glyphs: GlyphSet | None = None,
    aspect: float | None = None,
) -> Traits:
    """The traits by answers, command line and environment.

    Args:
        answers: The terminal's answers.
        environment: The environment's variables.
        size: Columns and rows.
        depth: Colours by the command line.
        glyphs: Characters for pixels by the command line.
        aspect: Shape of cells by the command line.
    """
    colours, why_colours = _colours(answers, environment, depth)
    blocks, why_blocks = _blocks(colours, glyphs)
    shape, why_shape = _shape(answers, size, aspect)
    reasons = {
        "depth": why_colours,
        "glyphs": why_blocks,
        "aspect": why_shape,
        "synchronized": _SILENT if answers.synchronized is None else _REPORTED,
        "acknowledges": "it answered where its cursor is"
        if answers.reports_cursor
        else "it did not answer where its cursor is",
        "releases": "it knows the kitty keyboard protocol"
        if answers.keyboard is not None
        else "it does not know the kitty keyboard protocol",
        "discards": "TMUX is set" if environment.get("TMUX") else "TMUX is not set",
    }
    return Traits(
        depth=colours,
        glyphs=blocks,
        aspect=shape,
        synchronized=bool(answers.synchronized),
        acknowledges=answers.reports_cursor,
        releases=answers.keyboard is not None,
        discards=bool(environment.get("TMUX")),
        reasons=reasons,
    )


def _colours(
    answers: Answers, environment: Mapping[str, str], given: ColourDepth | None
) -> tuple[ColourDepth, str]:
    if given is not None:
        return given, _GIVEN
    if environment.get("NO_COLOR"):
        return ColourDepth.MONO, "NO_COLOR is set"
    if answers.truecolour:
        return ColourDepth.TRUECOLOUR, _REPORTED
    return colours_by_environment(environment)


def _blocks(depth: ColourDepth, given: GlyphSet | None) -> tuple[GlyphSet, str]:
    blocks = (given or GlyphSet.HALF).at(depth)
    if depth is not ColourDepth.TRUECOLOUR:
        return blocks, "with these colours, both half blocks are needed"
    return blocks, _GIVEN if given else "all fonts have it, and no terminal tells more"


def _shape(answers: Answers, size: tuple[int, int], given: float | None) -> tuple[float, str]:
    if given is not None:
        return given, _GIVEN
    reported = answers.aspect(*size)
    if reported is None:
        return USUAL_ASPECT, _SILENT
    if not _ASPECTS[0] <= reported <= _ASPECTS[1]:
        return USUAL_ASPECT, f"the terminal says {reported:.2f}, which no font has"
    return reported, _REPORTED


def colours_by_environment(
    environment: Mapping[str, str], described: Callable[[str], int | None] | None = None
) -> tuple[ColourDepth, str]:
    """The terminal's colours by the environment, and the reason.

    COLORTERM, by which terminals claim truecolour, comes before the description of
    TERM.

    Args:
        environment: The variables.
        described: Number of colours in the description of a terminal, 0 for none, None
            where there is no description; terminfo's by default.
    """
    if environment.get("COLORTERM", "").lower() in {"truecolor", "24bit"}:
        return ColourDepth.TRUECOLOUR, f"COLORTERM is {environment['COLORTERM']}"
    name = environment.get("TERM", "")
    if not name and sys.platform == "win32":
        return ColourDepth.TRUECOLOUR, "consoles of Windows have them"
    if not name:
        return ColourDepth.MONO, "TERM is not set"
    colours = (described or _described)(name)
    if colours is None:
        # An unknown terminal is newer than this machine's descriptions.
        return ColourDepth.INDEXED_256, f"this machine has no description of {name}"
    reason = f"the description of {name} says {colours} colours"
    if colours >= 1 << 24:
        return ColourDepth.TRUECOLOUR, reason
    if colours >= 256:
        return ColourDepth.INDEXED_256, reason
    return (ColourDepth.INDEXED_16 if colours >= 8 else ColourDepth.MONO), reason


def _described(name: str) -> int | None:
    """Number of a terminal's colours by terminfo; only the first name of a process counts."""
    try:
        import curses
    except ImportError:  # Windows
        return None
    try:
        curses.setupterm(name, 1)
    except curses.error:
        return None
    return max(0, curses.tigetnum("colors"))
