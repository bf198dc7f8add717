"""A page of text over the view: the help or all messages, with scrolling and search."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterator, Sequence
from itertools import islice

from rune_tui.compositor.blend import Layer
from rune_tui.layout.actions import actions_of
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.own_keys import unbound
from rune_tui.model.page import Page
from rune_tui.overlays.help_page import PageLine, help_lines
from rune_tui.overlays.log_page import CLOCK_COLUMNS, log_lines
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.autopilot_words import unsafe_lines
from rune_tui.visualizers.parts.rows import cut, fitting_form
from rune_tui.visualizers.parts.severity import ink_of

_TWO_COLUMNS = 110
"""Least width for the help in two blocks side by side [cells]."""
_MOST_INPUTS = 26
"""Widest column of input names [cells]."""
_HEAD_ROWS = 2
"""Rows of the page's head: its title and its keys [cells]."""
_LEAST_WORDS = 8
FOOT_ROWS = 1
"""Rows at the end of a page that notices have for themselves [cells]."""
_CLOSE = {True: "? or escape: close", False: "escape: close"}


class PageLayer:
    """Draws an open page when it changes.

    Attributes:
        layers: The page; empty if none is open.
    """

    def __init__(self, layout: LayoutSpec) -> None:
        """Prepare the help of a layout."""
        self._actions = actions_of(layout)
        self._robots = frozenset(robot.name for robot in layout.robots)
        widgets = [*layout.view.widgets]
        for viewport in layout.view.viewports:
            widgets += viewport.widgets
        self._own = tuple(unbound(event.name for each in widgets for event in each.events))
        self._look: Hashable = None
        self.layers: tuple[Layer, ...] = ()

    def refresh(self, columns: int, top: int, rows: int, zpos: int, state: ConsoleState) -> bool:
        """Bring `layers` up to date.

        Args:
            columns: Width of the page [cells].
            top: Its first row [cells].
            rows: Its height [cells].
            zpos: Depth order of the layer.
            state: The console's state.

        Returns:
            Whether it changed.
        """
        seen = (columns, top, rows, zpos, state.theme.name, state.help, state.page)
        shown = state.notices if state.log else _unsafe(state)
        look: Hashable = (*seen, shown) if state.paged else None
        if look == self._look:
            return False
        self._look = look
        self.layers = ()
        if state.paged:
            canvas = Canvas.blank(columns, 2 * rows)
            self._draw(canvas, state)
            self.layers = (Layer(canvas=canvas, x=0, y=2 * top, zpos=zpos),)
        return True

    def within(self, page: Page, columns: int, rows: int, state: ConsoleState) -> Page:
        """The page, scrolled at most to its end."""
        lines, room = self._lines(columns, state), self._room(columns, rows, state)
        return dataclasses.replace(page, top=min(page.top, _last_top(lines, room, _height(rows))))

    def _draw(self, canvas: Canvas, state: ConsoleState) -> None:
        theme, columns = state.theme, canvas.width
        canvas.fill(theme.panel)
        lines = self._lines(columns, state)
        room = self._room(columns, canvas.rows, state)
        height = _height(canvas.rows)
        top = min(state.page.top, _last_top(lines, room, height))
        placed = [*islice(_in_columns(lines[top:], height), room)]
        shown = [line for line in placed if line is not None]
        canvas.text(1, 0, "HELP" if state.help else "MESSAGES", theme.accent)
        where = f"{top + 1}-{top + len(shown)} of {len(lines)}" if lines else "nothing"
        canvas.text(max(10, columns - 1 - len(where)), 0, where, theme.soft)
        canvas.text(1, 1, _hint(state, columns - 2), theme.soft)
        left, right, _ = self._widths(columns, state)
        for number, line in enumerate(placed):
            if line is None:
                continue
            column = 1 + number // height * (left + right + 2)
            row = _HEAD_ROWS + number % height
            if line.heading:
                canvas.text(column, row, cut(line.left, left + right + 1), theme.accent)
                continue
            canvas.text(column, row, cut(line.left, left), theme.ink)
            words = cut(line.right, right)
            canvas.text(column + left + 1, row, words, ink_of(line.severity, theme))

    def _room(self, columns: int, rows: int, state: ConsoleState) -> int:
        """Number of visible lines."""
        return _height(rows) * self._widths(columns, state)[2]

    @staticmethod
    def _widths(columns: int, state: ConsoleState) -> tuple[int, int, int]:
        """Widths of the two columns of a block [cells], and the number of blocks."""
        blocks = 2 if state.help and columns >= _TWO_COLUMNS else 1
        left = min(_MOST_INPUTS if state.help else CLOCK_COLUMNS, max(4, columns // 3))
        return left, max(_LEAST_WORDS, (columns - 2) // blocks - left - 2), blocks

    def _lines(self, columns: int, state: ConsoleState) -> list[PageLine]:
        left, right, _ = self._widths(columns, state)
        search = state.page.search
        if state.help:
            known = self._actions, self._own, self._robots
            unsafe = _unsafe(state)
            return [*help_lines(*known, unsafe=unsafe, search=search, left=left, right=right)]
        return [*log_lines(state, search=search, right=right)]


def _in_columns(lines: Sequence[PageLine], height: int) -> Iterator[PageLine | None]:
    """The lines in columns of a height; None in place of a heading that would end a column."""
    row = 0
    for line in lines:
        if line.heading and row % height == height - 1 and height > 1:
            row += 1
            yield None
        row += 1
        yield line


def _last_top(lines: Sequence[PageLine], room: int, height: int) -> int:
    """The first line of the last page."""
    top = max(0, len(lines) - room)
    while top < len(lines) and len([*_in_columns(lines[top:], height)]) > room:
        top += 1
    return top


def _unsafe(state: ConsoleState) -> tuple[tuple[str, str, str], ...]:
    """The unsafe parameters of all robots."""
    return tuple(
        (state.title(robot.name), parameter, why)
        for robot in state.robots.values()
        for parameter, why in unsafe_lines(robot)
    )


def _height(rows: int) -> int:
    """Rows of a page for its lines [cells]."""
    return max(1, rows - _HEAD_ROWS - FOOT_ROWS)


def _hint(state: ConsoleState, columns: int) -> str:
    """The keys of the page, in the longest form that fits."""
    page = state.page
    if page.typing:
        full = f"search: {page.search}_  enter: done · escape: all lines · the stop key stops"
        return fitting_form(columns, full, f"search: {page.search}_", f"/{page.search}_")
    close = "escape: all lines" if page.search else _CLOSE[state.help]
    found = f"with '{page.search}' · " if page.search else ""
    return fitting_form(
        columns,
        f"{found}{close} · / search · arrows, PgUp, PgDn, wheel: scroll · driving keys rest",
        f"{found}{close} · / search · PgUp, PgDn: scroll",
        f"{close} · / search",
        close,
        "esc",
    )
