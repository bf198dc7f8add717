"""The terminal's driver and its waiting output."""

from __future__ import annotations

import os
import signal
import sys
import time
from typing import Any

from textual.app import App
from textual.driver import Driver

from rune_tui.model.own_records import TerminalRecord
from rune_tui.terminal.traits import Traits
from rune_tui.ui.textual_inside import driver_of, writes_waiting


def output_is_pending(app: App[Any]) -> bool:
    """Whether output still waits for the terminal.

    The console draws only without waiting output. So a slow terminal does not block it, and the
    next frame is the newest.
    """
    return writes_waiting(driver_of(app)) > 0


def output_was_lost(app: App[Any]) -> bool:
    """Whether output was dropped since the last call, because the terminal blocked."""
    driver = driver_of(app)
    lost = bool(getattr(driver, "lost", False))
    if lost:
        driver.lost = False  # type: ignore[union-attr] # only `SturdyDriver` has it
    return lost


def suspend() -> bool:
    """Stop this process and its process group, as Ctrl-Z does in a shell.

    Returns:
        False if no shell can resume the process, as in `ssh -t robot rune run`.
    """
    if sys.platform == "win32" or os.getpgrp() == os.getsid(0):
        return False
    os.kill(os.getpid(), signal.SIGTSTP)
    return True


def terminal_driver() -> type[Driver] | None:
    """The driver to use; None for Textual's own, on Windows."""
    if sys.platform == "win32":
        return None
    from rune_tui.ui.sturdy_driver import SturdyDriver

    return SturdyDriver


def terminal_record(traits: Traits, pixels_per_cell: tuple[int, int]) -> TerminalRecord:
    """The terminal for a recording, without its size.

    Args:
        traits: Its abilities.
        pixels_per_cell: Pixels of a picture across and down a cell.
    """
    return TerminalRecord(
        colours=traits.depth.value,
        glyphs=traits.glyphs.value,
        aspect=traits.aspect,
        term=os.environ.get("TERM", ""),
        pixels_across=pixels_per_cell[0],
        pixels_down=pixels_per_cell[1],
        utc_offset_s=time.localtime().tm_gmtoff,
    )
