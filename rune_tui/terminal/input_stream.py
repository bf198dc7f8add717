"""What a terminal sends, taken apart into its answers and the rest: keys and the mouse; pure."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

HOLD_S: Final = 0.1
"""How long the beginning of a sequence waits for its end [s]; Alt and a letter look like one."""
_SEQUENCE: Final = re.compile(
    r"""\x1b\[M...                                     # X10 mouse: three characters follow
    |   \x1b\[[0-?]*[\ -/]*[@-~]                       # CSI (ECMA-48, 5.4)
    |   \x1b[P\]^_X][^\x1b\x07]*(?:\x1b\\|\x07)        # DCS, OSC, PM, APC, SOS up to ST or BEL
    """,
    re.VERBOSE | re.DOTALL,
)
_BEGUN: Final = re.compile(
    r"\x1b(?:\[(?:M.{0,2}|[0-?]*[ -/]*))?\Z|\x1b[P\]^_X][^\x1b\x07]*\x1b?\Z", re.DOTALL
)
"""The beginning of a sequence whose end has not come yet."""
_CURSOR: Final = re.compile(r"\x1b\[(\d{1,5});(\d{1,5})R")


@dataclass(frozen=True, slots=True, kw_only=True)
class CursorReport:
    """Where the terminal's cursor was when it came to the question, counted from 1."""

    row: int
    column: int


class InputStream:
    """Takes what was read, in pieces of any size.

    Reports of the cursor below the first row are answers; in the first row they are what xterm
    sends for F3 with a modifier. Sequences that nobody understands, such as late answers to other
    questions, are left out: as keys, they would drive.
    """

    def __init__(self, understood: Callable[[str], bool]) -> None:
        """Prepare.

        Args:
            understood: Whether whoever gets the rest knows what an escape sequence means.
        """
        self._understood = understood
        self._held = ""
        self._held_since = 0.0

    @property
    def holding(self) -> bool:
        """Whether the beginning of a sequence waits for its end."""
        return bool(self._held)

    def feed(self, text: str, now: float) -> Iterator[str | CursorReport]:
        """Answers, and what is no answer, in the order in which it came.

        To be called with nothing now and then while it is `holding`.

        Args:
            text: What was read.
            now: The time [s].
        """
        held, self._held = self._held, ""
        rest = []
        if held and now - self._held_since >= HOLD_S:
            rest.append(held)
            held = ""
        since = self._held_since if held else now
        text, at = held + text, 0
        for found in _SEQUENCE.finditer(text):
            rest.append(text[at : found.start()])
            at = found.end()
            cursor = _CURSOR.fullmatch(found[0])
            if cursor and int(cursor[1]) > 1:
                yield from filter(None, ("".join(rest),))
                rest.clear()
                yield CursorReport(row=int(cursor[1]), column=int(cursor[2]))
            elif self._understood(found[0]):
                rest.append(found[0])
        begun = _BEGUN.search(text, at)
        if begun:
            self._held, self._held_since = begun[0], since
        rest.append(text[at : begun.start() if begun else None])
        yield from filter(None, ("".join(rest),))
