"""Splits a terminal's input into its answers and the rest: keys and the mouse; pure."""

from __future__ import annotations

import enum
import re
from collections.abc import Callable, Iterator
from typing import Final

from hub.values import dataclass

HOLD_S: Final = 0.1
"""Time that the beginning of a sequence waits for its end [s]; Alt and a letter look like one."""
_LONGER_S: Final = 1.0
"""The same where Escape and Alt come as whole sequences: longer than a key is held in silence, so
no release in two pieces is lost."""
_SEQUENCE: Final = re.compile(
    r"""\x1b\[M...                                     # X10 mouse: three characters follow
    |   \x1b\[<[-\d;]*[Mm]                             # SGR mouse: beyond the edge it is negative
    |   \x1b\[\[[A-E]                                 # F1 to F5 of the Linux console
    |   \x1b\[[0-?]*[\ -/]*[@-Z\\-~]                     # CSI (ECMA-48, 5.4)
    |   \x1b[P\]^_X][^\x1b\x07]*(?:\x1b\\|\x07)        # DCS, OSC, PM, APC, SOS up to ST or BEL
    """,
    re.VERBOSE | re.DOTALL,
)
_BEGUN: Final = re.compile(
    r"\x1b(?:\[(?:M.{0,2}|<[-\d;]*|\[|[0-?]*[ -/]*))?\Z|\x1b[P\]^_X][^\x1b\x07]*\x1b?\Z", re.DOTALL
)
"""The beginning of an unfinished sequence."""
_ALT_KEY: Final = 2
"""Most characters of Escape and of a key with Alt."""
_CURSOR: Final = re.compile(r"\x1b\[(\d{1,5});(\d{1,5})R")
_KEYBOARD: Final = re.compile(r"\x1b\[\?(\d{1,5})u")
_KEY: Final = re.compile(
    r"""\x1b\[ (?P<code>\d{0,7}) (?::\d*(?::(?P<base>\d{1,7}))?[\d:]*)?  # with Shift, US
    (?: ; (?P<modifiers>\d{0,3}) (?: : (?P<move>[123]) )? )?
    (?: ; (?P<text>[\d:]*) )? (?P<final>[u~ABCDEFHPQS])
    """,
    re.VERBOSE,
)
"""A key by the kitty keyboard protocol; F3 there does not look like a cursor report."""
_PASTE_BEGINS: Final = "\x1b[200~"
_PASTE_ENDS: Final = "\x1b[201~"
_PASTING_S: Final = 2.0
"""Longest wait for the end of a paste [s]: until then, no key counts."""
_LONGEST_PASTE: Final = 1 << 16
"""Longest paste [characters]."""
_MUTILATED: Final = re.compile("\x1b[\\[P\\]^_X].+|\ufffd.*", re.DOTALL)
"""A sequence without its end, and what follows it; or what no character is."""
_REPORTS_RELEASES: Final = 2 | 8
"""Flags of the kitty keyboard protocol: events of keys, of those too that type text."""
_CTRL_OR_ALT: Final = 2 | 4
"""Bits of modifiers in the kitty keyboard protocol."""
_ASCII_END: Final = 0x80
KEYPAD: Final = (
    *("0", "1", "2", "3", "4", "5", "6", "7", "8", "9"),
    *("decimal", "divide", "multiply", "subtract", "add", "enter", "equal", "separator"),
    *("left", "right", "up", "down", "pageup", "pagedown", "home", "end", "insert", "delete"),
)
"""The keys of the keypad, in the order of their codes."""
_FIRST_OF_KEYPAD: Final = 57399


@dataclass(frozen=True, slots=True, kw_only=True)
class CursorReport:
    """Position of the terminal's cursor at the question, from 1."""

    row: int
    column: int


class KeyMove(enum.Enum):
    """The event of a key, by the numbers of the kitty keyboard protocol."""

    PRESS = 1
    REPEAT = 2
    RELEASE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyReport:
    """A key moved.

    Attributes:
        code: The terminal's number of the key, for any character.
        move: Its event.
        press: The text of the press from a terminal that reports only presses.
        keypad: Its name if it is one of the keypad, such as "kp_8", else empty.
        base: The character that the key types on a US keyboard; empty: not reported, or the same.
    """

    code: str
    move: KeyMove
    press: str
    keypad: str = ""
    base: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyboardReport:
    """The terminal's reports of keys.

    Attributes:
        reports_releases: Whether it reports repeats and releases of keys.
    """

    reports_releases: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Paste:
    """Pasted text between its brackets.

    Attributes:
        text: The text.
        whole: Whether its end came; if not, keys typed after it may be part of the text.
    """

    text: str
    whole: bool


@dataclass(frozen=True, slots=True)
class BrokenSequence:
    """Part of an escape sequence or of a character was lost, and the rest left out."""


InputPart = str | CursorReport | KeyReport | KeyboardReport | Paste | BrokenSequence


class InputStream:
    """Takes input in pieces of any size.

    After the terminal has confirmed that it reports releases, keys are `KeyReport`s. If it
    reports releases of some keys only, such as arrows, all keys count as without them. Reports of
    the cursor below the first row are answers; in the first row they are what xterm sends for F3
    with a modifier. Unknown sequences, such as late answers to other questions, are
    left out: as keys, they would drive. So is what remains of a mutilated sequence.
    """

    def __init__(self, understood: Callable[[str], bool]) -> None:
        """Prepare.

        Args:
            understood: Whether the receiver of the rest understands escape sequences.
        """
        self._understood = understood
        self._held = ""
        self._held_since = 0.0
        self._pasting = False
        self._paste = ""
        self._paste_since = 0.0
        self._reports_releases = False

    @property
    def holding(self) -> bool:
        """Whether the beginning of a sequence or of a paste waits for its end."""
        return bool(self._held) or self._pasting

    def feed(self, text: str, now: float) -> Iterator[InputPart]:
        """Answers and other input, in order.

        Call it without input repeatedly while it is `holding`.

        Args:
            text: The input.
            now: The time [s].
        """
        held, self._held = self._held, ""
        if held and now - self._held_since >= (_LONGER_S if self._reports_releases else HOLD_S):
            yield _given_up(held)
            held = ""
        since = self._held_since if held else now
        text = held + text
        while True:
            if not self._pasting:
                typed, begin, text = text.partition(_PASTE_BEGINS)
                yield from self._typed(typed, since, ended=bool(begin))
                if not begin:
                    return
                self._pasting, self._paste, self._paste_since = True, "", now
            self._paste, end, text = (self._paste + text).partition(_PASTE_ENDS)
            late = now - self._paste_since >= _PASTING_S or len(self._paste) > _LONGEST_PASTE
            if not (end or late):
                return
            self._pasting = False
            yield Paste(text=self._paste, whole=bool(end))
            if not end:
                return

    def _typed(self, text: str, since: float, *, ended: bool) -> Iterator[InputPart]:
        """The parts of input that is not pasted.

        Args:
            text: The input.
            since: The time from which the beginning of a sequence waits for its end [s].
            ended: Whether nothing can end a sequence that is begun here.
        """
        rest: list[str] = []
        at = 0
        for found in _SEQUENCE.finditer(text):
            yield from _keys(text[at : found.start()], rest)
            at = found.end()
            report = self._report(found[0])
            if isinstance(report, str):
                rest.append(report)
            elif report is not None:
                yield from _taken(rest)
                yield report
            elif self._understood(found[0]):
                rest.append(found[0])
        begun = None if ended else _BEGUN.search(text, at)
        if begun:
            self._held, self._held_since = begun[0], since
        yield from _keys(text[at : begun.start() if begun else None], rest)
        yield from _taken(rest)

    def _report(self, sequence: str) -> InputPart | None:
        """The meaning of a sequence, if it is more than a key or the mouse, or its replacement."""
        if (cursor := _CURSOR.fullmatch(sequence)) and int(cursor[1]) > 1:
            return CursorReport(row=int(cursor[1]), column=int(cursor[2]))
        if keyboard := _KEYBOARD.fullmatch(sequence):
            self._reports_releases = int(keyboard[1]) & _REPORTS_RELEASES == _REPORTS_RELEASES
            return KeyboardReport(reports_releases=self._reports_releases)
        key = _KEY.fullmatch(sequence)
        if key is None or not (self._reports_releases or key["move"]):
            return None
        if key["code"] and not int(key["code"]):
            return None  # text of an input method, which never goes up
        report = None if sequence == _PASTE_ENDS else self._key(key)
        if self._reports_releases or report is None:
            return report
        return "" if report.move is KeyMove.RELEASE else report.press

    def _key(self, found: re.Match[str]) -> KeyReport | None:
        move = KeyMove(int(found["move"] or 1))
        code, final = found["code"] or "1", found["final"]
        modifiers, text = found["modifiers"] or "1", found["text"]
        base = _base(found["base"])
        # Keys with Ctrl or Alt are named after Latin letters, on every keyboard.
        meant = str(ord(base)) if base and (int(modifiers) - 1) & _CTRL_OR_ALT else code
        parts = [meant, modifiers, *filter(None, [text])]
        if modifiers == "1" and not text:
            parts = [found["code"]]
        press = f"\x1b[{';'.join(parts)}{final}"
        if not self._understood(press):
            return None
        number = int(code) - _FIRST_OF_KEYPAD if final == "u" else -1
        keypad = f"kp_{KEYPAD[number]}" if 0 <= number < len(KEYPAD) else ""
        return KeyReport(code=f"{code}{final}", move=move, press=press, keypad=keypad, base=base)


def _base(code: str | None) -> str:
    """The character of a key on a US keyboard; empty if it types none."""
    character = chr(int(code)) if code and int(code) < _ASCII_END else ""
    return character if character.isprintable() and character != " " else ""


def _given_up(held: str) -> InputPart:
    """The meaning of the beginning of a sequence whose end never came."""
    return held if len(held) <= _ALT_KEY else BrokenSequence()


def _keys(text: str, rest: list[str]) -> Iterator[InputPart]:
    """Add keys between sequences to the rest; a mutilated sequence hides which of them are keys."""
    mutilated = _MUTILATED.search(text)
    rest.append(text[: mutilated.start()] if mutilated else text)
    if mutilated:
        yield from _taken(rest)
        yield BrokenSequence()


def _taken(rest: list[str]) -> Iterator[str]:
    """The rest so far as one part."""
    yield from filter(None, ("".join(rest),))
    rest.clear()
