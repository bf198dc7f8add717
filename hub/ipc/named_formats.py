"""Formats that go by a name, so that messages which share a struct write it once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hub.errors import MessageFormatError, RedefinedMessageError
from hub.ipc import format as formats

MAX_NAME_LENGTH = 64


class NamedFormats(Mapping[str, str]):
    """Names and what they stand for, each spelt out without names.

    A name is defined before another format uses it, so no format can contain itself.
    """

    def __init__(self) -> None:
        self._meaning: dict[str, str] = {}

    def __getitem__(self, name: str) -> str:
        return self._meaning[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._meaning)

    def __len__(self) -> int:
        return len(self._meaning)

    def define_format(self, name: str, text: str) -> None:
        """Let `name` stand for a format; to say the same again does nothing.

        Raises:
            MessageFormatError: The text is no format, or the name cannot stand for one.
            RedefinedMessageError: The name stands for another format.
        """
        good = name.isascii() and name.isidentifier() and len(name) <= MAX_NAME_LENGTH
        if not good or name == "enum" or name in formats.PRIMITIVES:
            reason = f"a format's name is 1 to {MAX_NAME_LENGTH} letters, digits and underscores"
            raise MessageFormatError(name, 0, f"{reason}, and no word of the grammar")
        # Known under its name while it is parsed, so that one that contains itself is told so.
        spelt = str(formats.parse(name, self._meaning | {name: text}))
        known = self._meaning.setdefault(name, spelt)
        if known != spelt:
            reason = f"the format {name!r} is already defined as {known[:80]}, not {spelt[:80]}"
            raise RedefinedMessageError(reason)

    def expand(self, text: str) -> str:
        """The format with every name replaced by what it stands for, as definitions need it.

        Raises:
            MessageFormatError: The text is no format.
        """
        return str(formats.parse(text, self._meaning))
