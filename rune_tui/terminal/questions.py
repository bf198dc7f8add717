"""What a terminal is asked at the start, and what its answers say; pure.

A terminal's name says little of what it can do, and less through tmux and SSH, so the terminal
itself is asked. The last question is one that every terminal answers, so that nobody has to wait
for those that this one does not know.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

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
    """What a terminal said of itself; None where it said nothing.

    Attributes:
        complete: Whether it came to the last question.
        synchronized: Whether it can show a frame all at once (mode 2026).
        truecolour: Whether it has 24-bit colours.
        cell: Width and height of a cell [pixels].
        area: Width and height of all cells [pixels].
        keyboard: Flags of the kitty keyboard protocol in force; None if it does not know it.
        reports_cursor: Whether it tells where its cursor is, so that frames can be acknowledged.
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
    """Whether the colour that was set is in force as it was set, or the terminal says so."""
    capability, colour = _CAPABILITY.search(data), _SGR.search(data)
    if capability and capability[1] == b"1":
        return True
    if colour and colour[1] == b"1":
        return any(own in colour[2] for own in _OWN_COLOUR)
    return None


def _size(found: re.Match[bytes] | None) -> tuple[int, int] | None:
    """Width and height, which terminals tell the other way round."""
    return (int(found[2]), int(found[1])) if found else None
