"""The questions to a terminal at the start, and its answers; pure.

A terminal's name tells little of its abilities, and less through tmux and SSH, so the terminal
itself is asked. Every terminal answers the last question: so there is no wait for answers that this
terminal does not have.
"""

from __future__ import annotations

import re
from typing import Final

from hub.values import dataclass

QUESTIONS: Final = (
    "\x1b[?2026$p"  # DECRQM: synchronized output
    "\x1b[48;2;1;2;3m\x1bP$qm\x1b\\\x1b[0m"  # DECRQSS: the colour that was just set
    "\x1bP+q524742\x1b\\"  # XTGETTCAP: RGB
    "\x1b[16t\x1b[14t"  # XTWINOPS: size of a cell, of the text area [pixels]
    "\x1b[?u"  # kitty keyboard protocol: flags in force
    "\x1b[2;1H\x1b[6n"  # DSR: where the cursor is
    "\x1b[c"  # DA1: answered by all
)
_SYNCHRONIZED: Final = re.compile(rb"\x1b\[\?2026;([0-4])\$y")
_SGR: Final = re.compile(rb"\x1bP([01])\$r([0-9;:]*)m\x1b\\")
_CAPABILITY: Final = re.compile(rb"\x1bP([01])\+r524742[^\x1b]*\x1b\\", re.IGNORECASE)
_CELL: Final = re.compile(rb"\x1b\[6;(\d{1,5});(\d{1,5})t")
_AREA: Final = re.compile(rb"\x1b\[4;(\d{1,5});(\d{1,5})t")
_KEYBOARD: Final = re.compile(rb"\x1b\[\?(\d{1,5})u")
_CURSOR: Final = re.compile(rb"\x1b\[\d{1,5};\d{1,5}R")
_ATTRIBUTES: Final = re.compile(rb"\x1b\[\?[0-9;]*c")
_OWN_COLOUR: Final = (b"48:2::1:2:3", b"48:2:1:2:3", b"48;2;1;2;3")


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """A terminal's answers; None: no answer.

    Attributes:
        complete: Whether it answered the last question.
        synchronized: Whether it can show a frame all at once (mode 2026).
        truecolour: Whether it has 24-bit colours.
        cell: Width and height of a cell [pixels].
        area: Width and height of all cells [pixels].
        keyboard: Active flags of the kitty keyboard protocol; None: it lacks the protocol.
        reports_cursor: Whether it reports its cursor, and so can acknowledge frames.
    """

    complete: bool = False
    synchronized: bool | None = None
    truecolour: bool | None = None
    cell: tuple[int, int] | None = None
    area: tuple[int, int] | None = None
    keyboard: int | None = None
    reports_cursor: bool = False

    def aspect(self, columns: int, rows: int) -> float | None:
        """Height of a cell over its width; None if not known.

        Args:
            columns: Width of the terminal [cells].
            rows: Height of the terminal [cells].
        """
        if self.cell and all(self.cell):
            return self.cell[1] / self.cell[0]
        if self.area and all(self.area) and columns > 0 and rows > 0:
            return self.area[1] / rows / (self.area[0] / columns)
        return None


def read_answers(data: bytes) -> Answers:
    """The answers in the input of a terminal, among other input."""
    mode, keyboard = _SYNCHRONIZED.search(data), _KEYBOARD.search(data)
    return Answers(
        complete=_ATTRIBUTES.search(data) is not None,
        synchronized=mode[1] in b"123" if mode else None,
        truecolour=_truecolour(data),
        cell=_size(_CELL.search(data)),
        area=_size(_AREA.search(data)),
        keyboard=int(keyboard[1]) if keyboard else None,
        reports_cursor=_CURSOR.search(data) is not None,
    )


def _truecolour(data: bytes) -> bool | None:
    """Whether the terminal kept the set colour, or reports truecolour."""
    capability, colour = _CAPABILITY.search(data), _SGR.search(data)
    if capability and capability[1] == b"1":
        return True
    if colour and colour[1] == b"1":
        return any(own in colour[2] for own in _OWN_COLOUR)
    return None


def _size(found: re.Match[bytes] | None) -> tuple[int, int] | None:
    """Width and height, which terminals report in reverse order."""
    return (int(found[2]), int(found[1])) if found else None
