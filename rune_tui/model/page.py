"""A page of text over the view, the help or the messages: its position and search."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

from hub.values import dataclass

LONGEST_SEARCH = 60
"""Most letters of a search."""
_END = 1_000_000
"""More lines than a page has."""
_SEARCH = "/"


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """The position and search of a page.

    Attributes:
        top: Number of lines above its upper edge.
        search: Only lines with this text are shown; empty: all.
        typing: Whether typed letters go to the search.
    """

    top: int = 0
    search: str = ""
    typing: bool = False


def turned(page: Page, key: str, rows: int) -> Page:
    """The page after a key; the same one if the key has no effect.

    Args:
        page: The page before.
        key: Its name in layouts; for the mouse wheel see `scrolled`.
        rows: Height of the terminal [cells].
    """
    if key in _MOVES:
        return scrolled(page, _MOVES[key](max(1, rows // 2)))
    if page.typing:
        return _typed(page, key)
    if key == _SEARCH:
        return dataclasses.replace(page, typing=True)
    if key == "escape" and page.search:
        return Page()
    return page


def scrolled(page: Page, lines: int) -> Page:
    """The page after a scroll by some lines; the drawing limits it at the end."""
    return dataclasses.replace(page, top=max(0, page.top + lines))


def _typed(page: Page, key: str) -> Page:
    if key == "enter":
        return dataclasses.replace(page, typing=False)
    if key == "escape":
        return Page()
    if key == "backspace":
        return dataclasses.replace(page, search=page.search[:-1], top=0)
    letter = " " if key == "space" else key
    if len(letter) == 1 and len(page.search) < LONGEST_SEARCH:
        return dataclasses.replace(page, search=page.search + letter, top=0)
    return page


_MOVES: Mapping[str, Callable[[int], int]] = {
    "up": lambda _: -1,
    "down": lambda _: 1,
    "pageup": lambda half: -half,
    "pagedown": lambda half: half,
    "home": lambda _: -_END,
    "end": lambda _: _END,
}
"""Lines that a key moves a page down, as a function of half the terminal's height."""
