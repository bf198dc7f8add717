"""The terminal itself: its driver, its colours, and how far behind it is with what it was sent.

Private API of Textual is touched here, in `sturdy_driver.py` and in `pixel_strip.py` only.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Any

from textual.app import App
from textual.driver import Driver

from rune_tui.compositor.depth import ColourDepth


def output_is_pending(app: App[Any]) -> bool:
    """Whether the terminal has not yet taken what was drawn before.

    Textual writes in a thread, from a queue that holds 30 pieces and then blocks the whole console.
    Drawing only while that queue is empty keeps the console alive when the terminal is slow or has
    stopped reading, and what it shows next is the newest frame.
    """
    writer = getattr(app._driver, "_writer_thread", None)  # noqa: SLF001 - no public way to ask
    return writer is not None and writer._queue.qsize() > 0  # noqa: SLF001 - as above


def terminal_driver() -> type[Driver] | None:
    """The driver to use; None for Textual's own, where ours does not work (Windows)."""
    if sys.platform == "win32":
        return None
    from rune_tui.ui.sturdy_driver import SturdyDriver

    return SturdyDriver


def colour_depth(
    environment: Mapping[str, str], described: Callable[[str], int | None] | None = None
) -> ColourDepth:
    """What colours the terminal has, by what the environment says of it.

    NO_COLOR (no-color.org) comes first, then COLORTERM, by which terminals tell that they have
    truecolour, then the description of TERM.

    Args:
        environment: The variables.
        described: How many colours the description of a terminal says it has, 0 for none, None
            where there is no description; terminfo's by default.
    """
    if environment.get("NO_COLOR"):
        return ColourDepth.MONO
    if environment.get("COLORTERM", "").lower() in {"truecolor", "24bit"}:
        return ColourDepth.TRUECOLOUR
    name = environment.get("TERM", "")
    if not name:
        # Consoles of Windows have truecolour and no name.
        return ColourDepth.TRUECOLOUR if sys.platform == "win32" else ColourDepth.MONO
    colours = (described or _described)(name)
    if colours is None:
        # A terminal that this machine has never heard of is newer than its descriptions.
        return ColourDepth.INDEXED_256
    if colours >= 1 << 24:
        return ColourDepth.TRUECOLOUR
    if colours >= 256:
        return ColourDepth.INDEXED_256
    return ColourDepth.INDEXED_16 if colours >= 8 else ColourDepth.MONO


def _described(name: str) -> int | None:
    """How many colours terminfo says a terminal has; only the first name of a process counts."""
    try:
        import curses
    except ImportError:  # Windows
        return None
    try:
        curses.setupterm(name, 1)
    except curses.error:
        return None
    return max(0, curses.tigetnum("colors"))
