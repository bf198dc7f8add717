"""The interface of visualizers: made from the layout, they draw one robot's state on a canvas."""

from __future__ import annotations

from collections.abc import Hashable
from typing import ClassVar, Protocol, Self

from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.raster.canvas import Canvas


class Visualizer(Protocol):
    """Turns the state of a robot into pixels and characters.

    Attributes:
        rule: Its element in layouts.
        whole_cells: Whether it writes characters and so needs a viewport of whole cells.

    An optional attribute `urgency` gives stops, drive state and ranges priority on a slow terminal.
    One with a memory has `__copy__`: a replay of a recording goes back to what it knew then. Its
    `memory_s` says how long ago what it shows may have been [s].
    A visualizer of pictures may have `camera`, and `interval_s`: the shortest time between two [s].
    """

    rule: ClassVar[VisualizerRule]
    whole_cells: ClassVar[bool]

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        ...

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw on a clear canvas of the viewport's size."""
        ...

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """A token that changes if and only if `draw` would draw something else."""
        ...


class PlainVisualizer:
    """Base of visualizers without options; most of them write characters."""

    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, _spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls()


class Locating(Protocol):
    """A visualizer with `locates` in its rule: it has the place of a pixel in the world."""

    def locate(
        self,
        pixel: tuple[float, float],
        size: tuple[int, int],
        robot: RobotState,
        state: ConsoleState,
    ) -> WorldPoint | None:
        """The place on the ground at a pixel of the newest drawing.

        Args:
            pixel: Distances from the left and upper edges of the viewport [pixels].
            size: Width and height of the viewport [pixels].
            robot: The drawn state, not a newer one.
            state: The state of the console.

        Returns:
            The place; None: the pixel shows no ground.
        """


class Naming(Protocol):
    """A visualizer that names what it shows of a robot, for `{shown}` in a title."""

    def shown_word(self, robot: RobotState) -> str:
        """The name, such as "depth"."""


class Overlaying(Protocol):
    """A visualizer with `draws_over` in its rule: ranges must not cover a part of it."""

    def draw_over(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw that part again, on a clear canvas.

        Args:
            canvas: As large as that of `draw`.
            robot: The state of the robot.
            state: The state of the console.
        """


class Picturing(Protocol):
    """A visualizer with `pictures` in its rule: it has the place of a pixel in the picture."""

    def picture_size(self, width: int, height: int) -> tuple[int, int]:
        """Width and height of the picture that fits a viewport of this size best [pixels]."""

    def in_picture(
        self,
        pixel: tuple[float, float],
        size: tuple[int, int],
        robot: RobotState,
        state: ConsoleState,
    ) -> tuple[float, float] | None:
        """The place of a pixel of the newest drawing in the camera's picture.

        Args:
            pixel: Distances from the left and upper edges of the viewport [pixels].
            size: Width and height of the viewport [pixels].
            robot: The drawn state, not a newer one.
            state: The state of the console.

        Returns:
            Shares of the picture's width and height, 0 to 1; None beside the picture.
        """
