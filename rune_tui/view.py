"""The whole picture: places viewports on the terminal, redraws what changed, composes the rest."""

from __future__ import annotations

import copy
import dataclasses
import logging
import time
from collections.abc import Callable, Mapping
from typing import cast

import numpy as np

from rune_tui.compositor.blend import Layer, compose, tinted, urgencies_of
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.contrast import make_legible
from rune_tui.compositor.seen_pictures import SeenPicture, seen_pictures
from rune_tui.controls.events import Hit
from rune_tui.drawn_viewport import DrawnViewport, DrawTimes, is_shown
from rune_tui.layout.placing import Area, Placed, arrangement_for, filled, given_away, placed
from rune_tui.layout.rules import Vocabulary
from rune_tui.layout.spec import CHOSEN, LayoutSpec, ViewportSpec
from rune_tui.model.attention import AttentionEntry, AttentionQueue
from rune_tui.model.body import lacks
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK, Theme
from rune_tui.overlays.banner_layer import BANNER_ROWS, TALL_ROWS, BannerLayer
from rune_tui.overlays.notice_layer import NoticeLayer, notice_only
from rune_tui.overlays.page_layer import PageLayer
from rune_tui.overlays.stop_layer import StopLayer
from rune_tui.raster.urgency import Urgencies
from rune_tui.visualizers.visualizer import Visualizer
from rune_tui.visualizers.words.title import with_title
from rune_tui.visualizers.words.troubles import banner_of, problems, troubles_of_all

_logger = logging.getLogger(__name__)

MIN_COLUMNS = 16
MIN_ROWS = 4
_STOP = "stop"
"""The word of lines of keys and of buttons for the key that stops."""
_LINE = 2
"""Most height of a pane that the banner spares [pixels]."""
_INVISIBLE = 255
"""Transparency of a viewport that cannot be seen."""


class View:
    """Turns the console's state into cells; draws nothing before the first `resize`.

    Attributes:
        places: Viewports that have a place at this size, and whether each is shown at first.
        attention: The queue of problems in the newest picture.
        arranged: How often the viewports were placed.
        times: Processor time of drawings.
        pictures: Pictures in the newest cells that have more than one pixel per half cell.
        urgencies: Urgency of each cell of the newest picture.
    """

    def __init__(
        self,
        layout: LayoutSpec,
        spent: Callable[[], float] = time.thread_time,
        *,
        pixels_per_cell: tuple[int, int] = (1, 2),
    ) -> None:
        """Prepare.

        Args:
            layout: The layout to draw.
            spent: Processor time of this thread [s]. Wall time would throttle drawings that a
                busy machine makes slow.
            pixels_per_cell: Pixels of pictures across and down a cell, as an `Output` shows them.
        """
        self._scale = pixels_per_cell[0], pixels_per_cell[1] // 2
        self.times = DrawTimes(spent)
        self.arranged = 0
        self._spec = layout.view
        self._vocabulary = layout.vocabulary
        self._choice = any(each.robot == CHOSEN for each in layout.view.viewports)
        self._look = "", "", ""
        self._columns = 0
        self._rows = 0
        self.panes: list[DrawnViewport] = []
        # Some keep a history of values, so a new size of the terminal does not replace them.
        self._visualizers: dict[str, Visualizer] = {}
        self._viewports = {each.name: each for each in self._spec.viewports if each.visualizer}
        self._complete = False
        self._failed = False
        self._full = ""
        self._vital: tuple[str, ...] = ()
        self._idle: frozenset[str] = frozenset()
        self._arrangement = self._spec.arrangements[0]
        self.places: Mapping[str, bool] = {}
        self._page = PageLayer(layout)
        self._paged = False
        self._page_rows = 0
        self._needs: Mapping[str, Mapping[str, PictureNeed]] = {}
        self._banner = BannerLayer()
        self._queue = AttentionQueue()
        self.attention: tuple[AttentionEntry, ...] = ()
        self._notices = NoticeLayer()
        self._stop = StopLayer()
        self.urgencies: Urgencies = np.zeros((0, 0), np.uint8)
        self.pictures: tuple[SeenPicture, ...] = ()

    def resize(self, columns: int, rows: int) -> bool:
        """Place all viewports on a terminal of this size [cells]; the next frame is complete.

        Returns:
            Whether another arrangement of the layout is now in use.
        """
        self._columns = max(0, columns)
        self._rows = max(0, rows)
        self._complete = False
        self.arranged += 1
        self.panes = []
        if self._too_small:
            return False
        before = self._arrangement
        self._arrangement = arrangement_for(self._spec.arrangements, columns, rows)
        self.places = {each.viewport: each.visible for each in self._arrangement.places}
        for place in self._places():
            viewport = self._viewports.get(place.spec.viewport)
            if viewport is None or place.spec.transparency == _INVISIBLE:
                continue
            shown = self._visualizer(viewport)
            title = "" if self._full else viewport.title
            head, area = with_title(place.area, title)
            self.panes.append(
                DrawnViewport(
                    spec=viewport,
                    visualizer=shown,
                    how=place.spec,
                    place=area,
                    head=head,
                    times=self.times,
                    scale=self._scale,
                    markable=self._choice,
                )
            )
        over = [each for each in self.panes if each.visualizer.rule.above]
        for pane in self.panes:
            above = [each.how.zpos for each in over if each.place.meets(pane.place)]
            pane.over_zpos = max([pane.how.zpos, *above]) if above else None
        return self._arrangement is not before

    def _places(self) -> tuple[Placed, ...]:
        """Places of the viewports on this terminal."""
        free = {
            name for name, each in self._viewports.items() if not self._visualizer(each).whole_cells
        }
        size = self._columns, self._rows
        if self._full or self._paged:
            full = "" if self._paged else self._full
            whole, *rest = filled(self._arrangement, full, self._vital, *size, free=free)
            self._page_rows = whole.area.height // 2
            return (whole, *rest)
        kept = given_away(self._arrangement.places, self._idle)
        return placed(dataclasses.replace(self._arrangement, places=kept), *size, free=free)

    def _visualizer(self, viewport: ViewportSpec) -> Visualizer:
        if viewport.name not in self._visualizers:
            self._visualizers[viewport.name] = _visualizer_of(viewport, self._vocabulary)
        return self._visualizers[viewport.name]

    def render(self, state: ConsoleState) -> Cells | None:
        """The picture now; None if it did not change since the last call.

        After a fault the picture shows the fault: an old picture must not look like a new one.
        """
        if not self._columns or not self._rows:
            return None
        try:
            cells = self._rendered(state)
        except Exception:  # the operator can still stop, and must see that the picture failed
            if self._failed:
                return None
            self._failed, self._complete = True, False
            _logger.exception("the picture cannot be made")
            layers = [self._notice_alone("this cannot be drawn; the log says why", state)]
            self.urgencies = urgencies_of(self._columns, self._rows, layers)
            self.pictures = ()
            return compose(self._columns, self._rows, self._background(state.theme), layers)
        self._failed = False
        return cells

    def feed(self, state: ConsoleState) -> None:
        """Take a state as `render` does, without drawing; the next `render` draws what is due."""
        try:
            _, changed = self._refreshed(state, draw=False)
            self._complete = self._complete and not changed
        except Exception:  # `render` shows and reports it
            _logger.debug("a frame cannot be taken", exc_info=True)
            self._complete = False

    def copied(self) -> View:
        """A view with the same memories, which goes on by itself."""
        twin = copy.copy(self)
        twin.times = copy.copy(self.times)
        shown = {name: copy.copy(each) for name, each in self._visualizers.items()}
        panes = [copy.copy(each) for each in self.panes]
        for pane in panes:
            pane.visualizer, pane.times = shown[pane.spec.name], twin.times
        overlays = ("_page", "_banner", "_notices", "_stop")
        parts = {name: copy.copy(vars(self)[name]) for name in overlays}
        vars(twin).update(parts, panes=panes, _visualizers=shown, _queue=self._queue.copied())
        return twin

    def _refreshed(self, state: ConsoleState, *, draw: bool) -> tuple[ConsoleState, bool]:
        """Refresh all parts; returns the state with its banner, and whether anything changed."""
        self._arrange(state)
        self.times.slow = {}
        found = troubles_of_all(state)
        self.attention = self._queue.look(problems(found), state.seen, state.now)
        state = dataclasses.replace(
            state,
            banner=banner_of(state, found),
            attention=self.attention,
            drawn=frozenset(pane.function for pane in self.panes if pane.visible(state)),
        )
        # Those that say how to stop come first; the status line says it where none does.
        telling = [pane for pane in self.panes if pane.visualizer.rule.text]
        rest = [pane for pane in self.panes if not pane.visualizer.rule.text]
        # Refreshes every pane: `any` over a generator would end at the first change.
        changed = [pane.refresh(state, draw=draw) for pane in telling]
        told = any(pane.says(_STOP) and not self._is_covered(pane, state) for pane in telling)
        state = dataclasses.replace(state, stop_told=told)
        changed += [pane.refresh(state, draw=draw) for pane in rest]
        changed.append(self._refresh_stop(state))
        changed.append(self._refresh_banner(state))
        top, rows = self._page_place
        nearest = self._top_zpos + 1
        changed.append(self._page.refresh(self._columns, top, rows, nearest, state))
        changed.append(self._refresh_notices(state))
        return state, any(changed)

    def _rendered(self, state: ConsoleState) -> Cells | None:
        state, changed = self._refreshed(state, draw=True)
        look = state.theme.name, state.chosen, state.peeked
        if self._complete and not changed and look == self._look:
            return None
        self._look, self._complete = look, True
        if self._too_small:
            layers = [self._notice_alone("too small", state)]
        else:
            layers = [layer for pane in self.panes for layer in pane.layers(state)]
            layers += [pane.over for pane in self.panes if pane.over is not None]
            layers += [*self._stop.layers, *self._page.layers]
            layers += [*self._notices.layers, *self._banner.layers]
        self.urgencies = urgencies_of(self._columns, self._rows, layers)
        cells = compose(self._columns, self._rows, self._background(state.theme), layers)
        make_legible(cells, state.theme.tint)
        self.pictures = seen_pictures(cells, layers, state.theme.tint)
        return tinted(cells, state.theme.tint)

    def hits(self, x: int, y: int, state: ConsoleState) -> tuple[Hit, ...]:
        """Viewports at a pixel of the terminal (column, 2 * row), nearest first."""
        if state.paged:
            return ()
        panes = sorted(self.panes, key=lambda pane: pane.how.zpos)
        found = (pane.hit(x, y, state) for pane in reversed(panes))
        return tuple(hit for hit in found if hit is not None)

    def picture_needs(self, state: ConsoleState) -> Mapping[str, Mapping[str, PictureNeed]]:
        """The 4:3 pictures that the viewports on the screen need, by robot and camera.

        A robot without a camera image on the screen is left out, and a camera that it has not.
        """
        self._arrange(state)
        if self._paged:
            return self._needs  # pictures must be new when the page closes
        needs: dict[str, dict[str, PictureNeed]] = {}
        for robot, camera, need in filter(None, (pane.need(state) for pane in self.panes)):
            known = needs.setdefault(robot, {})
            known[camera] = need.and_also(known.get(camera, need))
        self._needs = needs
        return needs

    def _arrange(self, state: ConsoleState) -> None:
        """Place the viewports again when one of them or a page fills the view, or one is idle."""
        full = state.full if state.full in self._viewports else ""
        vital = tuple(self._vital_names(full, state)) if full or state.paged else ()
        idle = self._idle_names(state)
        look = full, vital, state.paged, idle
        if look != (self._full, self._vital, self._paged, self._idle):
            self._full, self._vital, self._paged, self._idle = look
            self.resize(self._columns, self._rows)

    def _idle_names(self, state: ConsoleState) -> frozenset[str]:
        """Names of the viewports that can show nothing of their robot's body."""
        found = set()
        for name, viewport in self._viewports.items():
            rule = self._visualizer(viewport).rule
            robot = state.shown_robot(viewport.robot) if rule.measured else None
            if robot is not None and lacks(robot, rule.message):
                found.add(name)
        return frozenset(found)

    def _vital_names(self, full: str, state: ConsoleState) -> list[str]:
        """Names of the vital viewports that are shown; the robot in the full view comes first."""
        robot = self._viewports[full].robot if full else state.seen
        shown = [
            self._viewports[place.viewport]
            for place in self._arrangement.places
            if place.viewport in self._viewports and is_shown(place, state)
        ]
        vital = [each for each in shown if self._visualizer(each).rule.vital]
        return [each.name for each in sorted(vital, key=lambda each: each.robot != robot)]

    @property
    def columns(self) -> int:
        """Width of the terminal [cells]."""
        return self._columns

    @property
    def rows(self) -> int:
        """Height of the terminal [cells]."""
        return self._rows

    @property
    def _uncovered_rows(self) -> int:
        """Number of rows at the upper edge that nothing may cover: heads and vital viewports."""
        lines = {
            row
            for pane in self.panes
            if pane.place.width == self._columns
            and (pane.visualizer.rule.heads or pane.visualizer.rule.vital)
            for row in range(pane.place.y // 2, (pane.place.y + pane.place.height) // 2)
        }
        return next(row for row in range(len(lines) + 1) if row not in lines)

    @property
    def _page_place(self) -> tuple[int, int]:
        """First row and height of a page, between the banner and the vital viewports [cells]."""
        top = min(self._banner.end, self._page_rows - 1)
        return max(0, top), max(1, self._page_rows - top)

    def within_page(self, state: ConsoleState) -> ConsoleState:
        """The state with its page scrolled at most to the page's end."""
        page = self._page.within(state.page, self._columns, self._page_place[1], state)
        return dataclasses.replace(state, page=page)

    @property
    def _too_small(self) -> bool:
        return self._columns < MIN_COLUMNS or self._rows < MIN_ROWS

    def _refresh_banner(self, state: ConsoleState) -> bool:
        listed = any(pane.visualizer.rule.of_all and pane.visible(state) for pane in self.panes)
        return self._banner.refresh(self._banner_place(state), self._rows, state, listed=listed)

    def _banner_place(self, state: ConsoleState) -> Area:
        """The first row and the columns of the banner.

        It lies over the main picture, so that it hides no other pane, below lines at its upper
        edge. Where no picture takes more than half of the columns, it takes all of them.
        """
        top = self._uncovered_rows
        pictures = [
            pane.place
            for pane in self.panes
            if pane.visualizer.rule.pictures
            and pane.visible(state)
            and 2 * pane.place.width > self._columns
        ]
        whole = Area(x=0, y=0, width=self._columns, height=0)
        main = max(pictures, key=lambda each: each.width * each.height, default=whole)
        top = max(top, main.y // 2)
        lines = {
            pane.place.y // 2
            for pane in self.panes
            if pane.place.height <= _LINE and pane.place.meets(main) and pane.visible(state)
        }
        height = BANNER_ROWS if self._rows >= TALL_ROWS else 1
        while covered := lines.intersection(range(top, top + height)):
            top = max(covered) + 1
        return Area(x=main.x, y=2 * top, width=main.width, height=2)

    def _is_covered(self, pane: DrawnViewport, state: ConsoleState) -> bool:
        """Whether another viewport lies over a part of this one."""
        return any(
            other.place.meets(pane.place) and other.how.zpos >= pane.how.zpos
            for other in self.panes[self.panes.index(pane) + 1 :]
            if other.visible(state)
        )

    def _refresh_stop(self, state: ConsoleState) -> bool:
        told = state.stop_told or "visualizeStatus" in state.drawn
        return self._stop.refresh(self._columns, self._rows, self._top_zpos + 1, state, told=told)

    def _refresh_notices(self, state: ConsoleState) -> bool:
        logged = any(pane.visualizer.rule.logs and pane.visible(state) for pane in self.panes)
        return self._notices.refresh(
            (self._columns, self._rows),
            self._banner.end or self._uncovered_rows,
            self._top_zpos + 2,
            state,
            page_rows=self._page_rows,
            logged=logged,
        )

    def _background(self, theme: Theme) -> tuple[int, int, int]:
        """Colour behind all viewports; the layout's own colour applies to the dark theme only."""
        given = self._spec.background if theme is DARK else None
        return given or theme.ground[:3]

    @property
    def _top_zpos(self) -> int:
        return max((place.zpos for place in self._arrangement.places), default=0)

    def _notice_alone(self, text: str, state: ConsoleState) -> Layer:
        return notice_only(text, self._columns, self._rows, state.theme)


def _visualizer_of(viewport: ViewportSpec, vocabulary: Vocabulary) -> Visualizer:
    spec = viewport.visualizer
    if spec is None:
        text = f"viewport {viewport.name} has no visualizer"
        raise ValueError(text)
    return cast("Visualizer", vocabulary.visualizers[spec.function].from_spec(spec))
