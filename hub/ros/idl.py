"""Reads definitions of types in OMG IDL, in the part of it that ROS 2 uses: "ros2idl"."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final, NoReturn

from hub.errors import RosMessageError

Member = tuple[str, str, int | None]
"""Type, name, and count of a field: None for one value, 0 for a sequence."""

_MOST_DEPTH: Final = 16
_BLANKS = re.compile(r'//[^\n]*|/\*.*?\*/|#[^\n]*|"(?:[^"\\]|\\.)*"', re.DOTALL)
_TOKEN = re.compile(r"\s*(::|[A-Za-z_][\w]*|[-+]?[\d.][\w.+-]*|[^\s\w])")
_NUMBERS = {
    "boolean": "bool",
    "octet": "uint8",
    "char": "uint8",
    "short": "int16",
    "unsigned short": "uint16",
    "long": "int32",
    "unsigned long": "uint32",
    "long long": "int64",
    "unsigned long long": "uint64",
    "float": "float32",
    "double": "float64",
}


def structs_of(text: str) -> Mapping[str, tuple[Member, ...]]:
    """The structs of a file of IDL, by their names: "sensor_msgs/msg/Image".

    Raises:
        RosMessageError: It is no IDL that ROS 2 makes.
    """
    reader = _IdlReader(_TOKEN.findall(_BLANKS.sub(" ", text)))
    reader.definitions(())
    reader.end()
    return reader.structs


class _IdlReader:
    """Recursive descent over the words of one text."""

    def __init__(self, words: list[str]) -> None:
        self._words = words
        self._at = 0
        self._named: dict[str, tuple[str, int | None]] = {}
        self.structs: dict[str, tuple[Member, ...]] = {}

    def end(self) -> None:
        """Nothing may follow."""
        if self._peek():
            self._refuse("a bracket closes nothing")

    def definitions(self, path: tuple[str, ...]) -> None:
        """Read until the end of a module."""
        if len(path) > _MOST_DEPTH:
            self._refuse("modules within modules are too deep")
        while (word := self._peek()) and word != "}":
            self._next()
            if word == "@":
                self._annotation()
            elif word == "module":
                name = self._next()
                self._expect("{")
                self.definitions((*path, name))
                self._expect("}")
            elif word == "struct":
                self._struct(path)
            elif word == "typedef":
                kind, name, count = self._member()
                self._named["/".join((*path, name))] = kind, count
                self._named[name] = kind, count
            elif word == "const":
                while self._next() != ";":
                    pass
            elif word != ";":
                self._refuse(f"{word[:40]!r} is not expected")

    def _struct(self, path: tuple[str, ...]) -> None:
        name = self._next()
        self._expect("{")
        members: list[Member] = []
        while self._peek() != "}":
            if self._peek() == "@":
                self._next()
                self._annotation()
            else:
                members.append(self._member())
        self._expect("}")
        self.structs["/".join((*path, name))] = tuple(members)

    def _member(self) -> Member:
        """Read "type name;" or "type name[count];"."""
        kind, count = self._type()
        name = self._next()
        if self._peek() == "[":
            self._next()
            if count is not None:
                self._refuse(f"{name[:40]} is an array of arrays")
            count = self._number()
            self._expect("]")
        self._expect(";")
        return kind, name, count

    def _type(self) -> tuple[str, int | None]:
        word = self._next()
        if word == "sequence":
            self._expect("<")
            kind, count = self._type()
            if count is not None:
                self._refuse("there is a sequence of arrays")
            if self._peek() == ",":
                self._next()
                self._number()
            self._expect(">")
            return kind, 0
        if word in ("string", "wstring"):
            if self._peek() == "<":
                self._next()
                self._number()
                self._expect(">")
            return word, None
        while word in ("unsigned", "long", "unsigned long") and self._peek() in (
            *("long", "short", "double"),
        ):
            word = f"{word} {self._next()}"
        if word in _NUMBERS:
            return _NUMBERS[word], None
        while self._peek() == "::":
            self._next()
            word = f"{word}/{self._next()}"
        return self._named.get(word, (word, None))

    def _annotation(self) -> None:
        self._next()
        if self._peek() == "(":
            depth = 0
            while True:
                depth += {"(": 1, ")": -1}.get(self._next(), 0)
                if not depth:
                    return

    def _number(self) -> int:
        word = self._next()
        if not word.isdecimal() or not 1 <= len(word) <= 10 or not int(word):
            self._refuse(f"{word[:40]!r} is no length")
        return int(word)

    def _peek(self) -> str:
        return self._words[self._at] if self._at < len(self._words) else ""

    def _next(self) -> str:
        word = self._peek()
        if not word:
            self._refuse("it is cut")
        self._at += 1
        return word

    def _expect(self, wanted: str) -> None:
        word = self._next()
        if word != wanted:
            self._refuse(f"{word[:40]!r} is in place of {wanted!r}")

    def _refuse(self, reason: str) -> NoReturn:
        text = f"a definition in IDL cannot be read: {reason}"
        raise RosMessageError(text)
