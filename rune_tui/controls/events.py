"""Events of keys, the mouse and joysticks, in one form."""

from __future__ import annotations

from hub.values import dataclass
from rune_tui.model.world import WorldPoint

PAUSE_S = 0.3
"""A longer time between two ticks of the console is a pause of it [s]."""
STALE_S = 0.2
"""Input may be from a pause for this time after it [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hit:
    """A viewport under the mouse.

    Attributes:
        viewport: Its name.
        x: Distance from its left edge, as a share of its width, 0 to 1.
        y: Distance from its upper edge, as a share of its height, 0 to 1.
        place: The place in the world, if the viewport shows the world there.
        robot: The robot that it shows; empty: none.
        in_picture: The place in the camera's picture, if the viewport shows it: distances from its
            left and upper edges, as shares of its width and height, 0 to 1.
        camera: The camera of that picture; empty: the main one.
    """

    viewport: str
    x: float
    y: float
    place: WorldPoint | None = None
    robot: str = ""
    in_picture: tuple[float, float] | None = None
    camera: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEvent:
    """One input was pressed, repeated, moved or released.

    Attributes:
        name: The input's name, such as "w", "up", "ctrl+c", "mouse left", "mouse wheel",
            "joystick pad lefty".
        pressed: True: pressed, repeated or moved. False: released, or an axis in neutral.
        repeat: Whether it was pressed, or an axis out of neutral, before.
        value: 1 for keys; the clicks of a wheel, positive away from the operator; the counts of
            a ball; the position of an axis, -1 to 1.
        hits: The viewports under the mouse, the nearest first.
        fine: Whether Shift was down.
        timed: Whether its release is not reported, so that a time limit ends it.
        must_release_first: Whether it must not drive before it was released, as after a stop.
        proven: Whether this press was reported before with `must_release_first` and drives now.
        second: Whether this press was reported before as a repeat, and is known as a press now.
        stale: Whether it may have been typed during a pause of the console; then it must not
            move a robot.
    """

    name: str
    pressed: bool
    repeat: bool = False
    value: float = 1.0
    hits: tuple[Hit, ...] = ()
    fine: bool = False
    timed: bool = False
    must_release_first: bool = False
    proven: bool = False
    second: bool = False
    stale: bool = False
