"""Marks and the ghost of a mark, drawn where they are in the camera's picture."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Final

from hub.gcm.mapping import INTEREST_POINTS, PointKind
from rune_tui.model.console_state import ConsoleState, Ghost
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.line_of_sight import hidden
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import RobotState
from rune_tui.model.sightings import Sight
from rune_tui.model.theme import Theme
from rune_tui.model.world import SaidBy, WorldPoint, metres_text
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.map_marks import write_at

FARTHEST_M: Final = 15.0
"""Marks that are farther away are not drawn [m]."""
AGAIN: Final = "click again to mark it"
_REACH: Final = 3.0
"""Half the width of a ghost's cross [pixels]."""


@dataclass(frozen=True, slots=True)
class _Label:
    """Words at a place in the world."""

    place: WorldPoint
    words: str
    ink: Colour


def draw_marks(
    canvas: Canvas, geometry: PictureGeometry, pose: Pose, robot: RobotState, state: ConsoleState
) -> None:
    """Each mark that the camera sees, and the ghost with its distance.

    Args:
        canvas: What the picture is drawn on.
        geometry: The picture as it is drawn there.
        pose: Where the robot was when the picture was taken.
        robot: The robot.
        state: The console.
    """
    grid = robot.map.value if robot.map is not None else None
    for label in _labels(robot, state.theme):
        away = math.hypot(label.place.x - pose.x, label.place.y - pose.y)
        pixel = _pixel(label.place, geometry, pose) if away <= FARTHEST_M else None
        if pixel is not None and not hidden(label.place, pose, geometry.mount_forward, grid):
            write_at(canvas, pixel, f"{label.words} {away:.1f} m", label.ink, state.theme)
    ghost = state.ghosts.get(robot.name)
    pixel = _pixel(ghost.place, geometry, pose) if ghost is not None else None
    if ghost is not None and pixel is not None:
        _draw_ghost(canvas, pixel, ghost, state.theme)


def marks_source(robot: RobotState, state: ConsoleState) -> Hashable:
    """Changes with the marks and the ghost."""
    received = robot.newest(INTEREST_POINTS)
    return received and received.number, state.ghosts.get(robot.name)


def ghost_words(ghost: Ghost) -> str:
    """What a ghost says of itself, such as "victim? 2.1 m ±0.3 m at a wall of the map"."""
    place = ghost.place
    parts = [f"{ghost.kind.name.lower()}?"]
    if away := metres_text(place.distance, 1):
        parts.append(f"{away} m")
    if off := metres_text(place.uncertainty, 1):
        parts.append(f"±{off} m")
    if place.said_by in {SaidBy.MAP, SaidBy.RANGES}:
        parts.append(place.said_by.value)
    return " ".join(parts)


def _labels(robot: RobotState, theme: Theme) -> Iterator[_Label]:
    received = robot.newest(INTEREST_POINTS)
    for point in received.value.points if received is not None else ():
        victim = point.kind is PointKind.VICTIM
        place = WorldPoint(x=point.x, y=point.y, uncertainty=point.uncertainty)
        ink = theme.warning if victim else theme.good
        yield _Label(place, f"{'V' if victim else 'L'}{point.number}", ink)


def _pixel(place: WorldPoint, geometry: PictureGeometry, pose: Pose) -> tuple[float, float] | None:
    """Where a place is in the picture; None where it is not."""
    # What is above the ground looks as if the ground were as high and the camera lower.
    level = dataclasses.replace(geometry, mount_height=geometry.mount_height - place.height)
    seen = level.pixel(*pose.from_map((place.x, place.y)).tolist())
    return seen.pixel if seen.sight is Sight.INSIDE else None


def _draw_ghost(canvas: Canvas, pixel: tuple[float, float], ghost: Ghost, theme: Theme) -> None:
    with drawing(canvas) as pen:
        pen.cross(pixel, _REACH, theme.warning)
    left, below = pixel[0] - _REACH, pixel[1] + _REACH + 1.0
    for row, words in enumerate((ghost_words(ghost), AGAIN)):
        write_at(canvas, (left, below + 2.0 * row), words, theme.warning, theme)
