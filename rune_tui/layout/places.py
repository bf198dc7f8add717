"""The places of a file's elements and their attributes.

The parser reports only lines, and for a start tag the last one. In a well-formed text the rest is
easy: every `<` starts one of a few constructs, and quotes are in pairs.
"""

from __future__ import annotations

import bisect
import re
from collections.abc import Iterator, Mapping
from dataclasses import field

from hub.values import dataclass

# Each alternative ends with its construct, so no text within it looks like a start tag.
_THING = re.compile(
    r"""<!--.*?-->|<\?.*?\?>|<!\[CDATA\[.*?\]\]>|</[^>]*>
    |<(?P<name>[^\s/>]+)(?P<attributes>(?:[^"'>]|"[^"]*"|'[^']*')*+)>""",
    re.DOTALL | re.VERBOSE,
)
_ATTRIBUTE = re.compile(r"""([^\s=/]+)\s*=\s*(?:"[^"]*"|'[^']*')""")


@dataclass(frozen=True, slots=True, order=True)
class Place:
    """A place in a file.

    Attributes:
        path: The file as the operator named it.
        line: Line, counted from 1; 0 when the file as a whole is meant.
        column: Column in characters, counted from 1; 0 when it is not known.
    """

    path: str = ""
    line: int = 0
    column: int = 0

    def seen_from(self, other: Place) -> str:
        """The place in words, for a sentence about another one."""
        return f"line {self.line}" + ("" if self.path == other.path else f" of {self.path}")


@dataclass(frozen=True, slots=True, kw_only=True)
class StartTag:
    """Where an element begins.

    Attributes:
        place: Its `<`.
        attributes: The first letters of its attributes, by the names that the file writes.
    """

    place: Place
    attributes: Mapping[str, Place] = field(default_factory=dict)


def start_tags(text: str, path: str) -> Iterator[StartTag]:
    """All start tags of a well-formed XML text, in its order."""
    lines = [0, *(found.end() for found in re.finditer("\n", text))]

    def place(offset: int) -> Place:
        line = bisect.bisect_right(lines, offset)
        return Place(path, line, offset - lines[line - 1] + 1)

    for thing in _THING.finditer(text):
        if thing["name"] is not None:
            found = _ATTRIBUTE.finditer(text, *thing.span("attributes"))
            attributes = {one[1]: place(one.start()) for one in found}
            yield StartTag(place=place(thing.start()), attributes=attributes)
