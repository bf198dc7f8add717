"""Pages of text in this terminal: instructions, breaks, the start of a trial."""

from __future__ import annotations

import contextlib
import sys
import termios
import time
from collections.abc import Callable
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import Markdown, Static

from rune_study.session.progress import LeftError

_LOOK_S = 0.1


def read(text: str, *, seconds: float = 0.0, ended: Callable[[], bool] | None = None) -> None:
    """Show a page of Markdown until Enter is pressed.

    Args:
        text: The page.
        seconds: Enter works from this time on [s].
        ended: Ends the page in place of Enter, once it returns true; None: Enter does.

    Raises:
        LeftError: Ctrl-C was pressed.
    """
    forget_keys()
    if not PageScreen(text, seconds, ended).run():
        why = "left with Ctrl-C"
        raise LeftError(why)


def forget_keys() -> None:
    """Drop the keys that were typed before a screen was there: they meant another one."""
    with contextlib.suppress(termios.error, ValueError):
        termios.tcflush(sys.stdin, termios.TCIFLUSH)


class PageScreen(App[bool]):
    """A page; ends with whether it was read."""

    CSS = """
    #page { width: 76; max-width: 100%; height: 1fr; }
    #keys { dock: bottom; height: 1; padding: 0 2; }
    """
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar = [
        ("enter", "go_on", "Go on"),
        ("ctrl+c", "leave", "Leave"),
    ]

    def __init__(self, text: str, seconds: float, ended: Callable[[], bool] | None) -> None:
        super().__init__()
        self._text = text
        self._until = time.monotonic() + seconds
        self._ended = ended

    def compose(self) -> ComposeResult:
        """The page, and the keys below it."""
        with VerticalScroll(id="page"):
            yield Markdown(self._text)
        yield Static(self._keys(), id="keys", markup=False)

    def on_mount(self) -> None:
        """Look for the end."""
        self.set_interval(_LOOK_S, self._look)

    def action_go_on(self) -> None:
        """End, unless it is too early or another decides."""
        if self._ended is None and time.monotonic() >= self._until:
            self.exit(result=True)

    def action_leave(self) -> None:
        """Leave the session."""
        self.exit(result=False)

    def _look(self) -> None:
        if self._ended is not None and self._ended():
            self.exit(result=True)
        else:
            self.query_one("#keys", Static).update(self._keys())

    def _keys(self) -> str:
        left = self._until - time.monotonic()
        if self._ended is not None:
            return "Please wait for the experimenter."
        return f"Go on in {left:.0f} s." if left > 0.0 else "Enter: go on   arrows: scroll"
