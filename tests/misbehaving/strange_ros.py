"""Messages of ROS that have the right form and strange contents, and definitions that lie."""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Sequence
from typing import Any, Final

from hub.ros.schema import TEXT, RosField, RosType

_LETTERS: Final = {
    "bool": "?", "byte": "B", "char": "B", "octet": "B", "int8": "b", "uint8": "B", "int16": "h",
    "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f",
    "float64": "d",
}  # fmt: skip
_FLOATS: Final = (0.0, 1.0, -1.0, 0.5, *map(float, ("nan", "inf", "-inf")), 3e38, -3e38, 1e-45)
_DOUBLES: Final = (*_FLOATS, 1e308, -1e308, 5e-324, 1e150, 1e9)
_TEXTS: Final = (
    b"",
    b"odom",
    b"base_link",
    b"map",
    b"rgb8",
    b"jpeg",
    b"pan",
    b"\x1b]0;owned\x07\x1b[2J\x1b[31mArmed",
    b"\xff\xfe\x80 no UTF-8",
    b"a\r\nb\x00c",
    "\u202edesrever\u0301".encode(),
    b"%s%n{0}" * 60,
)
_LIES: Final = ("float64", "string", "uint8[]", "string[]", "bool", "int64", "float32[]", "int8")


class StrangeMessages:
    """Makes messages of a type, as CDR."""

    def __init__(self, chance: random.Random, odd: float = 0.3) -> None:
        """Begin.

        Args:
            chance: Decides.
            odd: Share of values that are strange.
        """
        self._chance, self._odd = chance, odd
        self._made = bytearray()

    def payload(self, kind: RosType) -> bytes:
        """The next message."""
        self._made = bytearray()
        self._message(kind)
        return b"\0\1\0\0" + bytes(self._made)

    def _message(self, kind: RosType) -> None:
        for each in kind.fields:
            self._field(each)

    def _field(self, each: RosField) -> None:
        count = each.count
        if count is None:
            self._single(each.kind)
            return
        if not count:
            count = self._chance.choice((0, 1, 1, 2, 3, 9))
            said = (
                count if self._chance.random() > 0.02 else self._chance.choice((2**31, 2**32 - 1))
            )
            self._number("uint32", said)
        for _ in range(count):
            self._single(each.kind)

    def _single(self, kind: str | RosType) -> None:
        if isinstance(kind, RosType):
            self._message(kind)
        elif kind == TEXT:
            text = self._chance.choice(_TEXTS) + b"\0"
            self._number("uint32", len(text))
            self._made += text
        else:
            self._number(kind, self._any(kind))

    def _any(self, kind: str) -> Any:
        letter = _LETTERS[kind]
        odd = self._chance.random() < self._odd
        if letter in "fd":
            return self._chance.choice(_DOUBLES if letter == "d" else _FLOATS) if odd else 0.5
        if not odd:
            return self._chance.choice((0, 1, 2, 3))
        bits = 8 * struct.calcsize(letter)
        least, most = (
            (0, 2**bits - 1) if letter.isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
        )
        return True if letter == "?" else self._chance.choice((least, most, most // 2, 100))

    def _number(self, kind: str, value: Any) -> None:
        letter = _LETTERS[kind]
        self._made += bytes(-len(self._made) % struct.calcsize(letter))
        self._made += struct.pack("<" + letter, value)


def lie(text: str, chance: random.Random, kinds: Sequence[str] = _LIES) -> str:
    """A definition in which a few fields have other types."""
    lines = text.splitlines()
    for _ in range(chance.randrange(1, 4)):
        at = chance.randrange(len(lines))
        if re.fullmatch(r"\S+ \w+", lines[at]) and not lines[at].startswith("MSG"):
            lines[at] = f"{chance.choice(kinds)} {lines[at].split()[1]}"
    return "\n".join(lines) + "\n"


_JSON: Final = (0, 1, -1, 2**31, 2**63, 2**70, 1e308, -1e308, 0.5, True, None, *_FLOATS[4:7])
_JSON_TEXTS: Final = ("odom", "base_link", "", "\ud800", "\x1b[31m", "9" * 5000)


def strange_json(kind: RosType, chance: random.Random, odd: float = 0.06) -> dict[str, Any]:
    """A message of a type in JSON, as values, in which some are missing or of another kind."""

    def single(of: str | RosType) -> Any:
        if chance.random() < odd:
            return _any_json(chance, 0)
        if isinstance(of, RosType):
            return strange_json(of, chance, odd)
        return chance.choice(_JSON_TEXTS) if of == TEXT else 1

    made: dict[str, Any] = {}
    for each in kind.fields:
        if chance.random() < odd / 2.0:
            continue
        if each.count is None:
            made[each.name] = single(each.kind)
        else:
            count = each.count or chance.randrange(4)
            made[each.name] = [single(each.kind) for _ in range(count)]
    return made


def _any_json(chance: random.Random, depth: int) -> Any:
    choice = chance.random()
    if choice < 0.3 and depth < 3:
        return [_any_json(chance, depth + 1) for _ in range(chance.randrange(4))]
    if choice < 0.5 and depth < 3:
        names = chance.sample(("x", "sec", "stamp", "data", "position", "w"), 3)
        return {name: _any_json(chance, depth + 1) for name in names}
    return chance.choice(_JSON if choice < 0.8 else _JSON_TEXTS)
