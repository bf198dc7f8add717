"""Marks and the ghost of a mark at their places in the camera's picture."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import Final

import numpy as np

from hub.gcm.mapping import INTEREST_POINTS, InterestPoint
from rune_tui.model.console_state import ConsoleState, Ghost
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.line_of_sight import hidden
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.model.world import DistanceSource, WorldPoint, metres_text
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.maps.map_marks import mark_word, write_at

FARTHEST_M: Final = 15.0
"""Marks that are farther away are not drawn [m]."""
_MOST: Final = 24
"""Most marks in a picture; more words would hide it, so the nearest win."""
AGAIN: Final = "click again to mark it"
_REACH: Final = 3.0
"""Half the width of a ghost's cross [pixels]."""


def draw_marks(
    canvas: Canvas, geometry: PictureGeometry, pose: Pose, robot: RobotState, state: ConsoleState
) -> None:
    """Marks that the camera sees, and the ghost with its distance.

    Args:
        canvas: Canvas of the picture.
        geometry: The picture as it is drawn there.
        pose: Where the robot was when the picture was taken.
        robot: The robot.
        state: The console.
    """
    grid = robot.map.value if robot.map is not None else None
    for mark, pixel, away in _in_picture(robot, geometry, pose):
        place = WorldPoint(x=mark.x, y=mark.y, uncertainty=mark.uncertainty, height=mark.height)
        if not hidden(place, pose, geometry.mount, grid):
            word, ink = mark_word(mark, state.theme)
            write_at(canvas, pixel, f"{word} {away:.1f} m", ink, state.theme)
    ghost = state.ghosts.get(robot.name)
    spot = _pixel(ghost.place, geometry, pose) if ghost is not None else None
    if ghost is not None and spot is not None:
        _draw_ghost(canvas, spot, ghost, state.theme)


def marks_source(robot: RobotState, state: ConsoleState) -> Hashable:
    """Changes with the marks and the ghost."""
    received = robot.newest(INTEREST_POINTS)
    return received and received.number, state.ghosts.get(robot.name)


def ghost_words(ghost: Ghost) -> str:
    """The words at a ghost, such as "victim? 2.1 m ±0.3 m at a wall of the map"."""
    place = ghost.place
    parts = [f"{ghost.kind.name.lower()}?"]
    if away := metres_text(place.distance, 1):
        parts.append(f"{away} m")
    if off := metres_text(place.uncertainty, 1):
        parts.append(f"±{off} m")
    if place.source in {DistanceSource.MAP, DistanceSource.RANGES}:
        parts.append(place.source.value)
    return " ".join(parts)


def _in_picture(
    robot: RobotState, geometry: PictureGeometry, pose: Pose
) -> Iterator[tuple[InterestPoint, tuple[float, float], float]]:
    """The nearest marks in the picture, farthest first, with pixel and distance [m]."""
    received = robot.newest(INTEREST_POINTS)
    marks = received.value.points if received is not None else ()
    if not marks:
        return
    # All at once: a robot may have a thousand, and each picture is drawn again.
    places = pose.from_map([(mark.x, mark.y) for mark in marks])
    away = np.hypot(places[:, 0], places[:, 1])
    seen = geometry.pixels(places, [mark.height for mark in marks])
    near = np.flatnonzero(seen.inside & (away <= FARTHEST_M))
    for number in reversed(near[np.argsort(away[near], kind="stable")][:_MOST].tolist()):
        x, y = seen.pixels[number].tolist()
        yield marks[number], (x, y), float(away[number])


def _pixel(place: WorldPoint, geometry: PictureGeometry, pose: Pose) -> tuple[float, float] | None:
    """The pixel of a place in the picture; None if outside."""
    seen = geometry.pixels(pose.from_map((place.x, place.y)), place.height)
    x, y = seen.pixels.tolist()
    return (x, y) if seen.inside else None


def _draw_ghost(canvas: Canvas, pixel: tuple[float, float], ghost: Ghost, theme: Theme) -> None:
    with drawing(canvas) as pen:
        pen.cross(pixel, _REACH, theme.warning)
    left, below = pixel[0] - _REACH, pixel[1] + _REACH + 1.0
    for row, words in enumerate((ghost_words(ghost), AGAIN)):
        write_at(canvas, (left, below + 2.0 * row), words, theme.warning, theme)
