"""The title of a pane: its name in a thin rule between it and the pane above."""

from __future__ import annotations

from collections.abc import Sequence

from rune_tui.layout.placing import Area
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, printable_text

_LEAST_ROWS = 3
"""Least height of a pane with a title [cells]."""
_RULE = "─"
_MARK = "▶ "
_BEFORE = 1
"""Length of the rule before the name [cells]."""


def with_title(area: Area, title: str) -> tuple[Area | None, Area]:
    """The areas of a pane's title, if it has one and room for it, and of its content."""
    if not title or area.height < 2 * _LEAST_ROWS or area.y % 2:
        return None, area
    head = Area(x=area.x, y=area.y, width=area.width, height=2)
    return head, Area(x=area.x, y=area.y + 2, width=area.width, height=area.height - 2)


def titled(head: Area, titles: Sequence[str], theme: Theme, *, marked: bool = False) -> Canvas:
    """The row of a title; a name that does not fit is left out, and the rule stays.

    Args:
        head: Where it is.
        titles: Forms of the name, the longest first.
        theme: Its colours.
        marked: Whether it differs from other titles.
    """
    canvas = Canvas.blank(head.width, head.height)
    canvas.fill(theme.ground)
    canvas.text(0, 0, _RULE * canvas.width, theme.faint)
    room = canvas.width - _BEFORE - 2
    forms = [(_MARK if marked else "") + printable_text(title) for title in titles]
    name = next((form for form in forms if len(form) <= room), forms[-1])
    if _BEFORE + len(name) + 2 <= canvas.width:
        canvas.text(_BEFORE, 0, f" {name} ", theme.ink if marked else theme.soft)
    elif marked:
        # The mark must be visible even if the name does not fit.
        name = name if len(name) <= canvas.width else _MARK
        canvas.text(0, 0, name[: canvas.width], theme.ink)
    return canvas
