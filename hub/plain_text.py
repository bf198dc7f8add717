"""Makes text safe to show: a terminal must not obey text from a robot, a file or ssh."""

from __future__ import annotations

import functools
import html
import unicodedata
from typing import Final

_HIDDEN: Final = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Control characters, what turns the direction of writing or is not seen, halves of pairs, and the
ends of lines and paragraphs."""
_KEPT: Final = frozenset("\n\t")


def is_plain(text: str, *, lines: bool = False) -> bool:
    """Whether a text is shown as it is; see `plain`."""
    if text.isprintable():
        return True
    return all(
        one.isprintable() or (lines and one in _KEPT) or unicodedata.category(one) not in _HIDDEN
        for one in set(text)
    )


def plain(text: str, *, lines: bool = False) -> str:
    r"""A text with its control characters as Python writes them, such as \x1b.

    Args:
        text: From any source.
        lines: Whether ends of lines and tabs stay.
    """
    if text.isprintable():
        return text
    return "".join(one if lines and one in _KEPT else _shown(one) for one in text)


@functools.lru_cache(maxsize=4096)
def _shown(one: str) -> str:
    if unicodedata.category(one) not in _HIDDEN:
        return one
    return one.encode("unicode_escape").decode()


def markup(text: str) -> str:
    """A text for HTML, SVG and XML: as `plain` with its lines, and no part of it is a tag."""
    return html.escape(plain(text, lines=True))  # noqa: TID251 - the one place


def counted(number: int, thing: str) -> str:
    """A number of things, in words: "1 trial", "2 trials"."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def bound_text(number: float) -> str:
    """A limit in digits that a reader can compare: 2147483647, not 2.14748e+09; 1e9 is 1e+09."""
    short = f"{number:g}"
    return str(int(number)) if number == number // 1 != float(short) else short
