"""Asks the terminal before the console starts; Unix only."""

from __future__ import annotations

import contextlib
import os
import selectors
import sys
import termios
import time
import tty
from collections.abc import Iterator
from typing import Any, Final

from rune_tui.terminal.questions import QUESTIONS, Answers, read_answers

WAIT_S: Final = 2.0
"""How long an answer may take, which is long for a terminal and not for a bad link [s]."""
_MOST_BYTES: Final = 65_536
_ENTER: Final = "\x1b[?1049h"
_LEAVE: Final = "\x1b[?1049l"
_MODES: Final = (1000, 1002, 1003, 1006, 1015, 1004, 2004, 2026)
"""Reports of the mouse, of focus and of pasting, and drawing that waits for its end."""
RESET: Final = "".join(f"\x1b[?{mode}l" for mode in _MODES) + "\x1b[<9u\x1b[0m\x1b[?25h"
"""Switches off what a killed console has left on: modes, keyboard protocol, colours."""


def ask(source: int, sink: int, wait_s: float = WAIT_S) -> tuple[Answers, float]:
    """A terminal's answers about itself, and their time [s].

    A console that was killed leaves its modes behind; they are ended first.

    The questions are asked on the alternate screen, so that a terminal that takes one for text does
    not show it for long. Keys that are pressed meanwhile are lost.

    Args:
        source: File descriptor to read from.
        sink: File descriptor to write to.
        wait_s: How long to wait at most [s].
    """
    began = time.monotonic()
    received = b""
    with unbuffered(source), contextlib.suppress(OSError):
        os.write(sink, f"{_ENTER}{RESET}{QUESTIONS}".encode())
        with selectors.DefaultSelector() as selector:
            selector.register(source, selectors.EVENT_READ)
            while len(received) < _MOST_BYTES and not read_answers(received).complete:
                left = began + wait_s - time.monotonic()
                if left <= 0.0 or not selector.select(left):
                    break
                piece = os.read(source, 4096)
                if not piece:
                    break
                received += piece
        took = time.monotonic() - began
        os.write(sink, _LEAVE.encode())
        return read_answers(received), took
    return read_answers(received), time.monotonic() - began


@contextlib.contextmanager
def unbuffered(source: int) -> Iterator[None]:
    """Input byte by byte, without echo; afterwards the old mode, or a shell's mode."""
    try:
        before = _for_a_shell(termios.tcgetattr(source))
    except termios.error:  # not a terminal
        yield
        return
    tty.setcbreak(source, termios.TCSANOW)
    try:
        yield
    finally:
        with contextlib.suppress(termios.error):
            termios.tcsetattr(source, termios.TCSANOW, before)


def _for_a_shell(modes: list[Any]) -> list[Any]:
    """The terminal's modes, with lines and echo where a console that was killed took both."""
    incoming, outgoing, control, local, *others = modes
    if not local & (termios.ICANON | termios.ECHO):
        incoming |= termios.ICRNL
        outgoing |= termios.OPOST | termios.ONLCR
        local |= termios.ICANON | termios.ECHO | termios.ISIG | termios.IEXTEN
    return [incoming, outgoing, control, local, *others]


def ask_own(wait_s: float = WAIT_S) -> tuple[Answers, float]:
    """The answers of this process's terminal; empty: it has none."""
    source, sink = sys.__stdin__, sys.__stderr__
    if source is None or sink is None or not (source.isatty() and sink.isatty()):
        return Answers(), 0.0
    return ask(source.fileno(), sink.fileno(), wait_s)
