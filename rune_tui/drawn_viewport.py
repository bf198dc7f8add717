"""A viewport, its visualizer, and the last drawing.

| case | shown |
| --- | --- |
| the source has not changed | the last drawing |
| a drawing took too long, and is not vital | the last drawing, with its period |
| the visualizer fails | a notice of the failure, until a drawing succeeds |
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Callable, Hashable, Iterator, Mapping
from typing import Final, cast

from hub.values import dataclass
from rune_tui.compositor.blend import Layer
from rune_tui.controls.events import Hit
from rune_tui.layout.placing import Area
from rune_tui.layout.spec import CHOSEN, PlaceSpec, ViewportSpec
from rune_tui.model.cameras import MAIN, camera_of
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.visualizer import Locating, Overlaying, Picturing, Visualizer
from rune_tui.visualizers.words.title import titled

_logger = logging.getLogger(__name__)

SLOW_S: Final = 0.25
"""Processor time of a drawing that delays the operator's inputs [s]."""
_PAUSE: Final = 10.0
"""Pause after a slow drawing, as a multiple of the drawing's time."""
_ROBOT: Final = "{robot}"
"""Stands for the robot's name in a title."""


class DrawTimes:
    """Processor time of drawings.

    Attributes:
        slow: Times of the newest frame's drawings that took more than `SLOW_S` [s], by viewport.
        given: Times that count instead of measured ones, where a frame is drawn again.
    """

    def __init__(self, spent: Callable[[], float]) -> None:
        """Measure with a clock, the processor time of this thread [s]."""
        self.spent = spent
        self.slow: dict[str, float] = {}
        self.given: Mapping[str, float] | None = None

    def since(self, began: float, viewport: str) -> float:
        """Time of a viewport's drawing [s]."""
        took = self.spent() - began
        if self.given is not None:
            took = self.given.get(viewport, 0.0)
        if took > SLOW_S:
            self.slow[viewport] = took
        return took


@dataclass(slots=True, kw_only=True)
class DrawnViewport:
    """A viewport, its visualizer, and the last drawing."""

    spec: ViewportSpec
    visualizer: Visualizer
    how: PlaceSpec
    place: Area
    head: Area | None
    times: DrawTimes
    scale: tuple[int, int] = (1, 1)
    paused_until: float = -math.inf
    layer: Layer | None = None
    over: Layer | None = None
    over_zpos: int | None = None
    markable: bool = False
    titled: tuple[tuple[str, tuple[str, ...], bool], Layer] | None = None
    source: Hashable = None
    drawn_robot: RobotState | None = None
    failed: bool = False
    lost: bool = False

    def visible(self, state: ConsoleState) -> bool:
        """Whether the viewport is shown, by its arrangement or as the full view."""
        return is_shown(self.how, state) or state.full == self.spec.name

    def refresh(self, state: ConsoleState) -> bool:
        """Draw again if the source has changed; returns whether the picture changed."""
        if not self.visible(state):
            gone, self.layer, self.over = self.layer is not None, None, None
            return gone
        robot = self.robot(state)
        if robot is None or (self._drew(robot) and state.now < self.paused_until):
            return False
        began = self.times.spent()
        try:
            source = self.visualizer.source(robot, state)
            if self.layer is not None and source == self.source:
                return False
            canvas, over = self._drawn(robot, state), self._drawn_over(robot, state)
            self.failed = False
        except Exception:  # a fault in one viewport must not blank the rest
            if self.failed:
                return False
            self.failed = True
            function = self.spec.visualizer.function if self.spec.visualizer else ""
            _logger.exception("viewport %s: %s failed", self.spec.name, function)
            source, over = object(), None
            canvas = Canvas.blank(self.place.width, self.place.height)
            write_notice(canvas, f"{function} failed; the log says why", state.theme)
        self._pause_after(self.times.since(began, self.spec.name), canvas, state)
        self.source = source
        self.drawn_robot = robot
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

    def _drew(self, robot: RobotState) -> bool:
        """Whether the last drawing is of this robot."""
        return self.layer is not None and (
            self.drawn_robot is None or self.drawn_robot.name == robot.name
        )

    def _pause_after(self, took: float, canvas: Canvas, state: ConsoleState) -> None:
        """Pause after a slow drawing and note the period on it; never if vital."""
        if took > SLOW_S and not self.visualizer.rule.vital:
            self.paused_until = state.now + _PAUSE * took
            canvas.text(
                0, 0, f"slow: drawn every {(1.0 + _PAUSE) * took:.0f} s", state.theme.alarm_ink
            )

    def layers(self, state: ConsoleState) -> Iterator[Layer]:
        """The drawing, and its title; the title of the chosen robot is marked."""
        if self.layer is None:
            return
        yield self.layer
        if (head := self.head) is not None:
            marked = self.markable and self.spec.robot == state.chosen
            look = state.theme.name, self._titles(state), marked
            if self.titled is None or self.titled[0] != look:
                row = titled(head, look[1], state.theme, marked=marked)
                self.titled = look, Layer(canvas=row, x=head.x, y=head.y, zpos=self.how.zpos)
            yield self.titled[1]

    def _titles(self, state: ConsoleState) -> tuple[str, ...]:
        """Its title, the longest form first; it says so if keys do not command what it shows."""
        robot = self.robot(state)
        title = self.spec.title.replace(_ROBOT, state.title(robot.name) if robot else "no robot")
        if self.spec.robot == CHOSEN and state.peeked and not self.visualizer.rule.of_all:
            return f"{title} · PEEK: keys drive nothing", f"{title} · PEEK", "PEEK"
        return title, title.split(" ")[0]

    def robot(self, state: ConsoleState) -> RobotState | None:
        """The robot that the viewport shows."""
        return state.shown_robot(self.spec.robot)

    def hit(self, x: int, y: int, state: ConsoleState) -> Hit | None:
        """The place of a terminal's pixel in this viewport; None if outside, or not shown."""
        place, robot, rule = self.place, self.drawn_robot, self.visualizer.rule
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
        except Exception:  # as above; then the place is unknown
            if not self.lost:
                _logger.exception("viewport %s cannot locate a click", self.spec.name)
            self.lost = True
        if shown is not None and not shown.in_range:
            shown = None
        return Hit(
            viewport=self.spec.name,
            x=pixel[0] / place.width,
            y=pixel[1] / place.height,
            place=shown,
            robot=robot.name if robot is not None else "",
            in_picture=in_picture,
            camera=self.camera(robot, state) if robot is not None else MAIN,
        )

    def camera(self, robot: RobotState, state: ConsoleState) -> str:
        """The camera that the viewport shows; the main one if its visualizer names none."""
        return camera_of(getattr(self.visualizer, "camera", MAIN), robot, state)

    def _drawn(self, robot: RobotState, state: ConsoleState) -> Canvas:
        canvas = Canvas.blank(self.place.width, self.place.height, scale=self.scale)
        self.visualizer.draw(canvas, robot, state)
        return canvas

    def _drawn_over(self, robot: RobotState, state: ConsoleState) -> Canvas | None:
        """The marks that ranges above this viewport must not cover; None if it has none."""
        if self.over_zpos is None or not self.visualizer.rule.draws_over:
            return None
        canvas = Canvas.blank(self.place.width, self.place.height)
        cast("Overlaying", self.visualizer).draw_over(canvas, robot, state)
        return canvas if canvas.glyphs.any() or canvas.pixels.any() else None


def is_shown(place: PlaceSpec, state: ConsoleState) -> bool:
    """Whether a viewport is shown: the operator's choice, else the arrangement's default."""
    return state.shown.get(place.viewport, place.visible)
