"""The whole picture: places viewports on the terminal, redraws what changed, composes the rest."""

from __future__ import annotations

import copy
import dataclasses
import logging
import time
from collections.abc import Callable, Mapping
from typing import cast

import numpy as np

from rune_tui.compositor.blend import Layer
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.controls.events import Hit
from rune_tui.drawn_layers import DrawnLayers
from rune_tui.drawn_viewport import DrawnViewport, DrawTimes, drawn_functions, is_shown
from rune_tui.layout.placing import Placed, arrangement_for, filled, given_away, placed
from rune_tui.layout.rules import Vocabulary
from rune_tui.layout.spec import CHOSEN, LayoutSpec, ViewportSpec
from rune_tui.model.attention import AttentionEntry, AttentionQueue
from rune_tui.model.body import lacks
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.console_state import ConsoleState
from rune_tui.overlays.notice_layer import notice_only
from rune_tui.overlays.page_layer import PageLayer
from rune_tui.raster.urgency import Urgencies
from rune_tui.top_layers import TopLayers, shows_stop
from rune_tui.visualizers.visualizer import Visualizer
from rune_tui.visualizers.words.title import with_title
from rune_tui.visualizers.words.troubles import banner_of, problems, troubles_of_all

_logger = logging.getLogger(__name__)

MIN_COLUMNS = 16
MIN_ROWS = 4
_INVISIBLE = 255
"""Transparency of a viewport that cannot be seen."""


class View:
    """Turns the console's state into cells; draws nothing before the first `resize`.

    Attributes:
        columns: Width of the terminal [cells].
        rows: Height of the terminal [cells].
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
        self.columns = 0
        self.rows = 0
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
        self._top = TopLayers()
        self._stop_shown = False
        self._queue = AttentionQueue()
        self.attention: tuple[AttentionEntry, ...] = ()
        self.urgencies: Urgencies = np.zeros((0, 0), np.uint8)
        self.pictures: tuple[SeenPicture, ...] = ()

    def resize(self, columns: int, rows: int) -> bool:
        """Place all viewports on a terminal of this size [cells]; the next frame is complete.

        Returns:
            Whether another arrangement of the layout is now in use.
        """
        self.columns = max(0, columns)
        self.rows = max(0, rows)
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
        size = self.columns, self.rows
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
        drawn = self.draw(state)
        return None if drawn is None else self.compose(drawn)

    def draw(self, state: ConsoleState) -> DrawnLayers | None:
        """The first half of `render`: the layers of the picture; None if none changed."""
        if not self.columns or not self.rows:
            return None
        try:
            return self._drawn(state)
        except Exception as error:  # noqa: BLE001 - the operator can still stop, and must see it
            return self._fault(state, error)

    def compose(self, drawn: DrawnLayers) -> Cells | None:
        """The second half of `render`: the cells of layers; None after a fault that is shown."""
        try:
            composed = drawn.composed()
        except Exception as error:  # noqa: BLE001 - as above
            fault = self._fault(drawn.state, error)
            return None if fault is None else self.compose(fault)
        self._failed = drawn.fault
        cells, self.urgencies, self.pictures = composed
        return cells

    def _fault(self, state: ConsoleState, error: Exception) -> DrawnLayers | None:
        """The notice of a fault; None if it is shown already."""
        if self._failed:
            return None
        self._failed, self._complete = True, False
        _logger.error("the picture cannot be made", exc_info=error)
        layers = [self._notice_alone("this cannot be drawn; the log says why", state)]
        ground = self._spec.background
        return DrawnLayers(state, self.columns, self.rows, ground, layers, fault=True)

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
        parts = {"_page": copy.copy(self._page), "_top": self._top.copied()}
        vars(twin).update(parts, panes=panes, _visualizers=shown, _queue=self._queue.copied())
        return twin

    def _refreshed(self, state: ConsoleState, *, draw: bool) -> tuple[ConsoleState, bool]:
        """Refresh all parts; returns the state with its banner, and whether anything changed."""
        self._arrange(state)
        self.times.slow = {}
        state = dataclasses.replace(state, stop_shown=self._stop_shown)
        found = troubles_of_all(state)
        self.attention = self._queue.look(problems(found), state.seen, state.now)
        state = dataclasses.replace(
            state,
            banner=banner_of(state, found),
            attention=self.attention,
            drawn=frozenset(drawn_functions(self.panes, state)),
        )
        # Lines of keys come first: the status line says how to stop where they do not.
        with_text = [pane for pane in self.panes if pane.visualizer.rule.text]
        others = [pane for pane in self.panes if not pane.visualizer.rule.text]
        # Refreshes every pane: `any` over a generator would end at the first change.
        changed = [pane.refresh(state, draw=draw) for pane in with_text]
        if (shown := shows_stop(self.panes, state)) is not self._stop_shown:
            self._stop_shown = shown
            state = dataclasses.replace(state, stop_shown=shown)
        changed += [pane.refresh(state, draw=draw) for pane in others]
        size = self.columns, self.rows
        changed.append(self._top.refresh_banner(self.panes, size, state))
        top, rows = self._page_place
        nearest = self._top_zpos + 1
        changed.append(self._page.refresh(self.columns, top, rows, nearest, state))
        page_rows = self._page_rows
        changed.append(self._top.refresh(self.panes, size, nearest, state, page_rows=page_rows))
        return state, any(changed)

    def _drawn(self, state: ConsoleState) -> DrawnLayers | None:
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
            layers += [*self._page.layers, *self._top.layers]
        return DrawnLayers(state, self.columns, self.rows, self._spec.background, layers)

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
        idle = frozenset(name for name in self._viewports if self._is_idle(name, state))
        look = full, vital, state.paged, idle
        if look != (self._full, self._vital, self._paged, self._idle):
            self._full, self._vital, self._paged, self._idle = look
            self.resize(self.columns, self.rows)

    def _is_idle(self, name: str, state: ConsoleState) -> bool:
        """Whether a viewport can show nothing of its robot's body."""
        viewport = self._viewports[name]
        rule = self._visualizer(viewport).rule
        robot = state.shown_robot(viewport.robot) if rule.measured else None
        return robot is not None and lacks(robot, rule.message)

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
    def _page_place(self) -> tuple[int, int]:
        """First row and height of a page, between the banner and the vital viewports [cells]."""
        top = min(self._top.banner_end, self._page_rows - 1)
        return max(0, top), max(1, self._page_rows - top)

    def within_page(self, state: ConsoleState) -> ConsoleState:
        """The state with its page scrolled at most to the page's end."""
        page = self._page.within(state.page, self.columns, self._page_place[1], state)
        return dataclasses.replace(state, page=page)

    @property
    def _too_small(self) -> bool:
        return self.columns < MIN_COLUMNS or self.rows < MIN_ROWS

    @property
    def _top_zpos(self) -> int:
        return max((place.zpos for place in self._arrangement.places), default=0)

    def _notice_alone(self, text: str, state: ConsoleState) -> Layer:
        return notice_only(text, self.columns, self.rows, state.theme)


def _visualizer_of(viewport: ViewportSpec, vocabulary: Vocabulary) -> Visualizer:
    spec = viewport.visualizer
    if spec is None:
        text = f"viewport {viewport.name} has no visualizer"
        raise ValueError(text)
    return cast("Visualizer", vocabulary.visualizers[spec.function].from_spec(spec))
