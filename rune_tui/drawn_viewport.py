"""A viewport, its visualizer, and the last drawing.

| case | shown |
| --- | --- |
| the source has not changed | the last drawing |
| a drawing took too long, and is not vital | the last drawing, with its period |
| the visualizer fails | a notice of the failure, until a drawing succeeds |
"""

from __future__ import annotations

import copy
import dataclasses
import logging
import math
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from typing import Final, NamedTuple, cast

from hub.values import dataclass
from rune_tui.compositor.blend import Layer
from rune_tui.controls.events import Hit
from rune_tui.layout.placing import Area
from rune_tui.layout.spec import CHOSEN, PlaceSpec, ViewportSpec
from rune_tui.model.cameras import MAIN, PictureNeed, camera_of, unknown_camera
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.visualizer import Locating, Naming, Overlaying, Picturing, Visualizer
from rune_tui.visualizers.words.title import titled

_logger = logging.getLogger(__name__)

SLOW_S: Final = 0.25
"""Processor time of a drawing that delays the operator's inputs [s]."""
_PAUSE: Final = 10.0
"""Pause after a slow drawing, as a multiple of the drawing's time."""
MIN_PICTURE: Final = (16, 12)
"""Smallest picture that is requested: width and height [pixels]."""
_ROBOT: Final = "{robot}"
"""Stands for the robot's name in a title."""
_SHOWN: Final = "{shown}"
"""Stands for the word of a `Naming` visualizer in a title."""


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


class Due(NamedTuple):
    """A drawing that was not made, with all that it needs."""

    visualizer: Visualizer
    robot: RobotState
    state: ConsoleState
    took: float


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
    due: Due | None = None

    def visible(self, state: ConsoleState) -> bool:
        """Whether the viewport is shown, by its arrangement or as the full view."""
        return is_shown(self.how, state) or state.full == self.spec.name

    def refresh(self, state: ConsoleState, *, draw: bool = True) -> bool:
        """Draw again if the source has changed; returns whether the picture changed.

        Args:
            state: The console's state.
            draw: Whether to draw now; False: only note the drawing, for the next call.
        """
        if not self.visible(state):
            gone, self.layer, self.over, self.due = self.layer is not None, None, None, None
            return gone
        robot = self.robot(state)
        if robot is None or (self._drew(robot) and state.now < self.paused_until):
            return self._catch_up(draw=draw)
        began = self.times.spent()
        try:
            source = self.visualizer.source(robot, state)
            if self.layer is not None and source == self.source:
                return self._catch_up(draw=draw)
            if not draw and self.layer is not None:
                took = self.times.since(began, self.spec.name)
                self._pause_after(took, state)
                self.due = Due(copy.copy(self.visualizer), robot, state, took)
                self.source, self.drawn_robot = source, robot
                return True
            canvas, over = self._drawn(robot, state), self._drawn_over(robot, state)
            self.failed = False
        except Exception:  # a fault in one viewport must not blank the rest
            if self.failed:
                return False
            self.failed = True
            _logger.exception("viewport %s: %s failed", self.spec.name, self.function)
            source, over = object(), None
            canvas = self._failure(state)
        self.due = None
        took = self.times.since(began, self.spec.name)
        if self._pause_after(took, state):
            _write_pause(canvas, took, state)
        self.source = source
        self._keep(canvas, over, robot)
        return True

    def _catch_up(self, *, draw: bool) -> bool:
        """Draw what was noted before, as it was then; returns whether there was any."""
        if self.due is None or not draw:
            return False
        due, self.due = self.due, None
        own, self.visualizer = self.visualizer, due.visualizer
        try:
            canvas, over = self._drawn(due.robot, due.state), self._drawn_over(due.robot, due.state)
        except Exception:  # as above
            _logger.exception("viewport %s: %s failed", self.spec.name, self.function)
            canvas, over, self.source = self._failure(due.state), None, object()
        finally:
            self.visualizer = own
        if due.took > SLOW_S and not self.visualizer.rule.vital:
            _write_pause(canvas, due.took, due.state)
        self._keep(canvas, over, due.robot)
        return True

    def says(self, words: Collection[str]) -> bool:
        """Whether a row of the last drawing has all these words, in letters of any case."""
        rows = self.layer.canvas.glyphs.tolist() if self.layer is not None else ()
        said = ("".join(chr(each or 32) for each in row).casefold() for row in rows)
        return any(all(word in row for word in words) for row in said)

    @property
    def function(self) -> str:
        """The name of its visualizer in layouts."""
        return self.spec.visualizer.function if self.spec.visualizer else ""

    def _failure(self, state: ConsoleState) -> Canvas:
        """The notice of a drawing that failed."""
        canvas = Canvas.blank(self.place.width, self.place.height)
        write_notice(canvas, f"{self.function} failed; the log says why", state.theme)
        return canvas

    def _keep(self, canvas: Canvas, over: Canvas | None, robot: RobotState) -> None:
        """Keep a drawing as the layer."""
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

    def _drew(self, robot: RobotState) -> bool:
        """Whether the last drawing is of this robot."""
        return self.layer is not None and (
            self.drawn_robot is None or self.drawn_robot.name == robot.name
        )

    def _pause_after(self, took: float, state: ConsoleState) -> bool:
        """Pause after a slow drawing, never if vital; returns whether it pauses."""
        slow = took > SLOW_S and not self.visualizer.rule.vital
        if slow:
            self.paused_until = state.now + _PAUSE * took
        return slow

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
        if _SHOWN in title and self.visualizer.rule.names and robot is not None:
            title = title.replace(_SHOWN, cast("Naming", self.visualizer).shown_word(robot))
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

    def need(self, state: ConsoleState) -> tuple[str, str, PictureNeed] | None:
        """The robot, camera and picture that it needs; None: no picture."""
        robot, shown = self.robot(state), self.visualizer
        if not shown.rule.pictures or robot is None or not self.visible(state):
            return None
        camera = self.camera(robot, state)
        if unknown_camera(camera, robot):
            return None
        more = max(self.scale)
        width, height = more * self.place.width, more * self.place.height
        size = cast("Picturing", shown).picture_size(width, height)
        interval = float(getattr(shown, "interval_s", 0.0))
        return robot.name, camera, PictureNeed(size=max(size, MIN_PICTURE), interval_s=interval)

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


def _write_pause(canvas: Canvas, took: float, state: ConsoleState) -> None:
    """Note the period of a slow drawing on it."""
    canvas.text(0, 0, f"slow: drawn every {(1.0 + _PAUSE) * took:.0f} s", state.theme.alarm_ink)


def drawn_functions(
    panes: Iterable[DrawnViewport], state: ConsoleState
) -> Iterator[tuple[str, str]]:
    """Function and robot of each visualizer that is shown."""
    for pane in panes:
        robot = pane.robot(state)
        if robot is not None and pane.visible(state):
            yield pane.function, robot.name


def is_shown(place: PlaceSpec, state: ConsoleState) -> bool:
    """Whether a viewport is shown: the operator's choice, else the arrangement's default."""
    return state.shown.get(place.viewport, place.visible)
