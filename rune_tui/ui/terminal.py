"""The terminal itself: its driver, and how far behind it is with what it was sent.

Private API of Textual is touched here, in `sturdy_driver.py` and in `pixel_strip.py` only.
"""

from __future__ import annotations

import sys
from typing import Any

from textual.app import App
from textual.driver import Driver


def output_is_pending(app: App[Any]) -> bool:
    """Whether the terminal has not yet taken what was drawn before.

    Textual writes in a thread, from a queue that holds 30 pieces and then blocks the whole console.
    Drawing only while that queue is empty keeps the console alive when the terminal is slow or has
    stopped reading, and what it shows next is the newest frame.
    """
    writer = getattr(app._driver, "_writer_thread", None)  # noqa: SLF001 - no public way to ask
    return writer is not None and writer._queue.qsize() > 0  # noqa: SLF001 - as above


def output_was_lost(app: App[Any]) -> bool:
    """Whether something was not written since this was asked last, as the terminal took nothing."""
    driver = app._driver  # noqa: SLF001 - as above
    lost = bool(getattr(driver, "lost", False))
    if lost:
        driver.lost = False  # type: ignore[union-attr] # only ours has it
    return lost


def terminal_driver() -> type[Driver] | None:
    """The driver to use; None for Textual's own, where ours does not work (Windows)."""
    if sys.platform == "win32":
        return None
    from rune_tui.ui.sturdy_driver import SturdyDriver

    return SturdyDriver
