"""The terminal itself: its driver, and how far behind it is with what it was sent."""

from __future__ import annotations

import os
import signal
import sys
from typing import Any

from textual.app import App
from textual.driver import Driver

from rune_tui.ui.textual_inside import driver_of, writes_waiting


def output_is_pending(app: App[Any]) -> bool:
    """Whether the terminal has not yet taken what was drawn before.

    Drawing only when it has keeps the console alive when the terminal is slow or has stopped
    reading, and what it shows next is the newest frame.
    """
    return writes_waiting(driver_of(app)) > 0


def output_was_lost(app: App[Any]) -> bool:
    """Whether something was not written since this was asked last, as the terminal took nothing."""
    driver = driver_of(app)
    lost = bool(getattr(driver, "lost", False))
    if lost:
        driver.lost = False  # type: ignore[union-attr] # only ours has it
    return lost


def suspend() -> bool:
    """Stop this process and what was started with it, as Ctrl-Z does in a shell.

    Returns:
        False where no shell is there that could have it go on, as in `ssh -t robot rune run`.
    """
    if sys.platform == "win32" or os.getpgrp() == os.getsid(0):
        return False
    os.kill(os.getpid(), signal.SIGTSTP)
    return True


def terminal_driver() -> type[Driver] | None:
    """The driver to use; None for Textual's own, where ours does not work (Windows)."""
    if sys.platform == "win32":
        return None
    from rune_tui.ui.sturdy_driver import SturdyDriver

    return SturdyDriver
