"""What keys and devices become before anything else sees them."""

from __future__ import annotations

from dataclasses import dataclass

from rune_tui.model.world import WorldPoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Hit:
    """A viewport under the mouse.

    Attributes:
        viewport: Its name.
        x: Where in it, right of its left edge, as a share of its width, 0 to 1.
        y: Where in it, below its upper edge, as a share of its height, 0 to 1.
        place: Where in the world that is, if the viewport shows the world there.
        robot: The robot it shows; empty if it shows none.
        in_picture: Where in the camera's picture that is, if the viewport shows that: right of
            its left edge and below its upper edge, as shares of its width and height, 0 to 1.
    """

    viewport: str
    x: float
    y: float
    place: WorldPoint | None = None
    robot: str = ""
    in_picture: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEvent:
    """An input moved: a key went down, repeated, or went up; the mouse or a joystick did something.

    Attributes:
        name: The input's name, such as "w", "up", "ctrl+c", "mouse left", "mouse wheel",
            "joystick pad lefty".
        pressed: Whether it went down (or repeats, or moved); False when it went up, or when an
            axis is back in neutral.
        repeat: Whether it was down, or an axis out of neutral, already.
        value: How far: 1 for keys, the clicks of a wheel, positive away from the operator, the
            counts of a ball; of an axis where it is, -1 to 1.
        hits: The viewports under the mouse, the nearest first.
        fine: Whether Shift was held with it.
        timed: Whether nobody reports its release, so that it is guessed by time.
        must_release_first: Whether it must not drive: a key that was down at a stop or the like
            must be released first.
        proven: Whether this press was reported before with `must_release_first`, and may drive now.
        stale: Whether it may have been typed while the console was away, so that it counts only
            where it cannot move a robot.
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
    stale: bool = False
