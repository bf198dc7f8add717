"""A viewport, the visualizer that draws it, and what it drew last.

| case | what it shows |
| --- | --- |
| nothing of what it draws has changed | what it drew last |
| a drawing takes too long | the last one, which says how often it is drawn; never what is vital |
| the visualizer fails | that it failed, until it draws again |
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from typing import Final, cast

from rune_tui.compositor.blend import Layer
from rune_tui.controls.events import Hit
from rune_tui.layout.placing import Area
from rune_tui.layout.spec import PlaceSpec, ViewportSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.visualizer import Locating, Overlaying, Picturing, Visualizer
from rune_tui.visualizers.words.title import titled

_logger = logging.getLogger(__name__)

SLOW_S: Final = 0.25
"""A drawing that takes more of the processor's time delays the operator's inputs [s]."""
_REST: Final = 10.0
"""How many times as long as such a drawing took its viewport rests."""


@dataclass(slots=True, kw_only=True)
class DrawnViewport:
    """A viewport, its visualizer, and what was drawn last."""

    spec: ViewportSpec
    visualizer: Visualizer
    how: PlaceSpec
    place: Area
    head: Area | None
    spent: Callable[[], float]
    scale: tuple[int, int] = (1, 1)
    rests_until: float = -math.inf
    layer: Layer | None = None
    over: Layer | None = None
    over_zpos: int | None = None
    markable: bool = False
    titled: tuple[tuple[str, bool], Layer] | None = None
    source: Hashable = None
    drawn_of: RobotState | None = None
    failed: bool = False
    lost: bool = False

    def visible(self, state: ConsoleState) -> bool:
        """Whether it is to be seen."""
        return is_shown(self.how, state) or state.full == self.spec.name

    def refresh(self, state: ConsoleState) -> bool:
        """Draw again if that would show something else; whether it did."""
        if not self.visible(state):
            gone, self.layer, self.over = self.layer is not None, None, None
            return gone
        robot = self.robot(state)
        if robot is None or (self.layer is not None and state.now < self.rests_until):
            return False
        began = self.spent()
        try:
            source = self.visualizer.source(robot, state)
            if self.layer is not None and source == self.source:
                return False
            canvas, over = self._drawn(robot, state), self._drawn_over(robot, state)
            self.failed = False
        except Exception:  # a fault in one picture must not take the others from the operator
            if self.failed:
                return False
            self.failed = True
            function = self.spec.visualizer.function if self.spec.visualizer else ""
            _logger.exception("viewport %s: %s failed", self.spec.name, function)
            source, over = object(), None
            canvas = Canvas.blank(self.place.width, self.place.height)
            write_notice(canvas, f"{function} failed; the log says why", state.theme)
        self._rest_after(self.spent() - began, canvas, state)
        self.source = source
        self.drawn_of = robot
        self.layer = Layer(
            canvas=canvas,
            x=self.place.x,
            y=self.place.y,
            zpos=self.how.zpos,
            transparency=self.how.transparency,
            urgency=getattr(self.visualizer, "urgency", Urgency.OTHER),
        )
        self.over = None
        if over is not None and self.over_zpos is not None:
            self.over = dataclasses.replace(self.layer, canvas=over, zpos=self.over_zpos)
        return True

    def _rest_after(self, took: float, canvas: Canvas, state: ConsoleState) -> None:
        """Rest after a drawing that took too long [s], and say so on it; never what is vital."""
        if took > SLOW_S and not self.visualizer.rule.vital:
            self.rests_until = state.now + _REST * took
            canvas.text(
                0, 0, f"slow: drawn every {(1.0 + _REST) * took:.0f} s", state.theme.alarm_ink
            )

    def layers(self, state: ConsoleState) -> Iterator[Layer]:
        """What it shows, and its title, which is marked where its robot is the chosen one."""
        if self.layer is None:
            return
        yield self.layer
        if (head := self.head) is not None:
            look = state.theme.name, self.markable and self.spec.robot == state.chosen
            if self.titled is None or self.titled[0] != look:
                row = titled(head, self.spec.title, state.theme, marked=look[1])
                self.titled = look, Layer(canvas=row, x=head.x, y=head.y, zpos=self.how.zpos)
            yield self.titled[1]

    def robot(self, state: ConsoleState) -> RobotState | None:
        """The robot that it shows."""
        return state.robot(self.spec.robot)

    def hit(self, x: int, y: int, state: ConsoleState) -> Hit | None:
        """Where in it a pixel of the terminal lies, if it does and somebody can see it."""
        place, robot, rule = self.place, self.drawn_of, self.visualizer.rule
        across, down = x - place.x, y - place.y
        inside = 0 <= across < place.width and 0 <= down < place.height
        if not inside or not self.visible(state):
            return None
        shown, in_picture = None, None
        pixel, size = (across + 0.5, down + 0.5), (place.width, place.height)
        try:
            if robot is not None and rule.locates:
                shown = cast("Locating", self.visualizer).locate(pixel, size, robot, state)
            if robot is not None and rule.pictures:
                picturing = cast("Picturing", self.visualizer)
                in_picture = picturing.in_picture(pixel, size, robot, state)
        except Exception:  # as above; then no place is known there
            if not self.lost:
                _logger.exception("viewport %s cannot tell what was clicked", self.spec.name)
            self.lost = True
        if shown is not None and not shown.sayable:
            shown = None
        return Hit(
            viewport=self.spec.name,
            x=pixel[0] / place.width,
            y=pixel[1] / place.height,
            place=shown,
            robot=robot.name if robot is not None else "",
            in_picture=in_picture,
        )

    def _drawn(self, robot: RobotState, state: ConsoleState) -> Canvas:
        canvas = Canvas.blank(self.place.width, self.place.height, scale=self.scale)
        self.visualizer.draw(canvas, robot, state)
        return canvas

    def _drawn_over(self, robot: RobotState, state: ConsoleState) -> Canvas | None:
        """What the ranges over it must not cover; None if there is nothing."""
        if self.over_zpos is None or not self.visualizer.rule.draws_over:
            return None
        canvas = Canvas.blank(self.place.width, self.place.height)
        cast("Overlaying", self.visualizer).draw_over(canvas, robot, state)
        return canvas if canvas.glyphs.any() or canvas.pixels.any() else None


def is_shown(place: PlaceSpec, state: ConsoleState) -> bool:
    """Whether a viewport is shown: as the operator wants it, else as its arrangement says."""
    return state.shown.get(place.viewport, place.visible)
