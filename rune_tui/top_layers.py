"""The layers over the panes: the banner, notices and how to stop; their places follow the panes."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Final

from rune_tui.compositor.blend import Layer
from rune_tui.drawn_viewport import DrawnViewport
from rune_tui.layout.placing import Area
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.overlays.banner_layer import BANNER_ROWS, TALL_ROWS, BannerLayer
from rune_tui.overlays.notice_layer import NoticeLayer
from rune_tui.overlays.stop_layer import StopLayer

_LINE: Final = 2
"""Most height of a pane that the banner spares [pixels]."""
_STOP: Final = "stop"
"""The word beside the stop key, on lines of keys and on buttons."""


class TopLayers:
    """Draws the layers when they change."""

    def __init__(self) -> None:
        self._banner = BannerLayer()
        self._notices = NoticeLayer()
        self._stop = StopLayer()

    def copied(self) -> TopLayers:
        """The same layers, which go on by themselves."""
        twin = TopLayers()
        vars(twin).update({name: copy.copy(each) for name, each in vars(self).items()})
        return twin

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Where two lie at one place, the later one is above."""
        return (*self._stop.layers, *self._notices.layers, *self._banner.layers)

    @property
    def banner_end(self) -> int:
        """The row below the banner [cells]; 0: there is none."""
        return self._banner.end

    def refresh_banner(
        self, panes: Sequence[DrawnViewport], size: tuple[int, int], state: ConsoleState
    ) -> bool:
        """Bring the banner up to date in a view of this size [cells]; whether it changed."""
        listed = any(pane.visualizer.rule.of_all and pane.visible(state) for pane in panes)
        place = _banner_area(panes, state, size, _uncovered_rows(panes, size[0]))
        return self._banner.refresh(place, size[1], state, listed=listed)

    def refresh(
        self,
        panes: Sequence[DrawnViewport],
        size: tuple[int, int],
        zpos: int,
        state: ConsoleState,
        *,
        page_rows: int,
    ) -> bool:
        """Bring the other layers up to date.

        Args:
            panes: The panes of the view.
            size: Columns and rows of the view [cells].
            zpos: Depth order of a page, which is above all panes.
            state: The console's state.
            page_rows: Rows down to the end of a page over the view [cells].

        Returns:
            Whether they changed.
        """
        shown = state.stop_shown or ("visualizeStatus", state.seen) in state.drawn
        stop = self._stop.refresh(*size, zpos, state, shown=shown)
        logged = any(pane.visualizer.rule.logs and pane.visible(state) for pane in panes)
        top = self._banner.end or _uncovered_rows(panes, size[0])
        notices = self._notices.refresh(
            size, top, zpos + 1, state, page_rows=page_rows, logged=logged
        )
        return stop or notices


def _uncovered_rows(panes: Sequence[DrawnViewport], columns: int) -> int:
    """Number of rows at the upper edge that nothing may cover: heads and vital viewports."""
    lines = {
        row
        for pane in panes
        if pane.place.width == columns
        and (pane.visualizer.rule.heads or pane.visualizer.rule.vital)
        for row in range(pane.place.y // 2, (pane.place.y + pane.place.height) // 2)
    }
    return next(row for row in range(len(lines) + 1) if row not in lines)


def _banner_area(
    panes: Sequence[DrawnViewport], state: ConsoleState, size: tuple[int, int], top: int
) -> Area:
    """The first row and the columns of the banner.

    It lies over the main picture, so that it hides no other pane, below lines at its upper edge.
    Where no picture takes more than half of the columns, it takes all of them.

    Args:
        panes: The panes of the view.
        state: The console's state.
        size: Columns and rows of the view [cells].
        top: The first row that may be covered [cells].
    """
    columns, rows = size
    shown = [pane for pane in panes if pane.visible(state)]
    pictures = [
        pane.place
        for pane in shown
        if pane.visualizer.rule.pictures and 2 * pane.place.width > columns
    ]
    whole = Area(x=0, y=0, width=columns, height=0)
    main = max(pictures, key=lambda each: each.width * each.height, default=whole)
    lines = {
        pane.place.y // 2 for pane in shown if pane.place.height <= _LINE and pane.place.meets(main)
    }
    top = max(top, main.y // 2)
    height = BANNER_ROWS if rows >= TALL_ROWS else 1
    while covered := lines.intersection(range(top, top + height)):
        top = max(covered) + 1
    return Area(x=main.x, y=2 * top, width=main.width, height=_LINE)


def shows_stop(panes: Sequence[DrawnViewport], state: ConsoleState) -> bool:
    """Whether a line of keys or a button that nothing covers shows the key that stops."""
    words = {_STOP, state.input_of(Purpose.STOP, state.seen).casefold()}
    shown = [pane for pane in panes if pane.visible(state)]
    return any(
        pane.visualizer.rule.text
        and pane.says(words)
        and not any(
            over.place.meets(pane.place) and over.how.zpos >= pane.how.zpos
            for over in shown[number + 1 :]
        )
        for number, pane in enumerate(shown)
    )
