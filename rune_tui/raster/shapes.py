"""Draws lines, rectangles, circles, pies, polygons and marks on a canvas, with Pillow."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from PIL import Image, ImageDraw

from hub.values import dataclass
from rune_tui.raster.canvas import Canvas, Colour

Point = tuple[float, float]
"""x right, y down from the upper left corner of the canvas [pixels]; pixel (0, 0) spans 0 to 1."""

_FAR: Final = 4.0
"""Lines are cut at this multiple of the canvas's width and height."""
_CORNERS: Final = 256
"""Number of corners of a polygon that replaces a large circle with a small visible part."""
"""From an arrow's tip to its other two corners, seen from its middle [rad]."""


@dataclass(frozen=True, slots=True)
class Pen:
    """Draws in canvas coordinates; a shape replaces its pixels, alpha included.

    Attributes:
        draw: Pillow's drawing on the enlarged picture.
        scale: Pixels of the enlarged picture per pixel of the canvas.
        width: Width of the canvas [pixels].
        height: Height of the canvas [pixels].
    """

    draw: ImageDraw.ImageDraw
    scale: int
    width: int
    height: int

    def line(self, points: Sequence[Point], colour: Colour, width: float = 1.0) -> None:
        """Join points by straight lines `width` pixels thick."""
        thickness = max(1, round(width * self.scale))
        for piece in self._nearby(points):
            self.draw.line([self._at(point) for point in piece], colour, thickness, joint="curve")

    def dashes(
        self, points: Sequence[Point], colour: Colour, *, dash: float, gap: float, width: float = 1
    ) -> None:
        """Join points by dashed straight lines.

        Args:
            points: Corners; the pattern goes on around them.
            colour: Its colour.
            dash: Length of a dash [pixels], greater than 0.
            gap: Length of a gap [pixels], at least 0.
            width: Thickness [pixels].
        """
        period = dash + gap
        gone = 0.0
        for begin, end in itertools.pairwise(points):
            length = math.dist(begin, end)
            # Only the visible part: the line may start far outside the canvas.
            near, far = self._near(begin, end, length)
            for number in range(
                math.floor((gone + near) / period), math.ceil((gone + far) / period)
            ):
                first = max(near, number * period - gone)
                last = min(far, number * period + dash - gone)
                if first < last:
                    spots = (_between(begin, end, way / length) for way in (first, last))
                    self.line(list(spots), colour, width)
            gone = (gone + length) % period

    def cross(self, centre: Point, reach: float, colour: Colour, width: float = 1.0) -> None:
        """A diagonal cross; `reach` is half its width [pixels]."""
        x, y = centre
        for side in (reach, -reach):
            self.line([(x - reach, y - side), (x + reach, y + side)], colour, width)

    def rectangle(self, left: float, top: float, right: float, bottom: float, fill: Colour) -> None:
        """Fill from `left` to `right` and `top` to `bottom`; an empty span draws nothing."""
        x0, y0 = self._at((left, top))
        x1, y1 = self._at((right, bottom))
        # Pillow counts the last pixel in.
        if round(x1) > round(x0) and round(y1) > round(y0):
            self.draw.rectangle((round(x0), round(y0), round(x1) - 1, round(y1) - 1), fill)

    def polygon(self, points: Sequence[Point], fill: Colour) -> None:
        """Fill the area inside the points."""
        self.draw.polygon([self._at(point) for point in points], fill)

    def circle(
        self, centre: Point, radius: float, *, fill: Colour | None = None, rim: Colour | None = None
    ) -> None:
        """A circle, filled, outlined one pixel thick, or both."""
        radius = self._visible(centre, radius)
        if radius <= self._far:
            self.draw.ellipse(self._box(centre, radius), fill, rim, self.scale if rim else 0)
            return
        turns = (math.tau * corner / _CORNERS for corner in range(_CORNERS + 1))
        edge = [toward(centre, radius, turn) for turn in turns]
        if fill is not None:
            self.polygon(edge, fill)
        if rim is not None:
            self.line(edge, rim)

    def pie(
        self, centre: Point, radius: float, direction: float, opening: float, fill: Colour
    ) -> None:
        """A filled slice of a circle.

        Args:
            centre: Its tip.
            radius: Its radius [pixels].
            direction: Where its middle points [rad], counter-clockwise from up.
            opening: Its angle [rad].
            fill: Its colour.
        """
        start, end = _pillow_angles(direction, opening)
        radius = self._visible(centre, radius)
        if 0.0 < radius <= self._far:
            self.draw.pieslice(self._box(centre, radius), start, end, fill)

    def arc(
        self, centre: Point, radius: float, direction: float, opening: float, colour: Colour
    ) -> None:
        """The rim of a pie, one pixel thick, inside `radius`; arguments as for `pie`."""
        start, end = _pillow_angles(direction, opening)
        radius = self._visible(centre, radius)
        if 0.0 < radius <= self._far:
            self.draw.arc(self._box(centre, radius), start, end, colour, self.scale)

    @property
    def _far(self) -> float:
        """Largest radius [pixels]: Pillow takes time for each pixel of a rim, visible or not."""
        return 4.0 * _FAR * (self.width + self.height)

    def _visible(self, centre: Point, radius: float) -> float:
        """The radius, limited to just beyond the farthest corner of the canvas."""
        across = max(abs(centre[0]), abs(self.width - centre[0]))
        down = max(abs(centre[1]), abs(self.height - centre[1]))
        return min(radius, math.hypot(across, down) + 2.0)

    def _at(self, point: Point) -> Point:
        return point[0] * self.scale, point[1] * self.scale

    def _nearby(self, points: Sequence[Point]) -> Iterator[Sequence[Point]]:
        """The visible pieces of a line; Pillow takes time for each invisible pixel."""
        far = _FAR * (self.width + self.height)
        if all(abs(x) <= far and abs(y) <= far for x, y in points):
            yield points
            return
        for begin, end in itertools.pairwise(points):
            length = math.dist(begin, end)
            near, beyond = self._near(begin, end, length)
            if near < beyond:
                yield [_between(begin, end, way / length) for way in (near, beyond)]

    def _box(self, centre: Point, radius: float) -> tuple[float, float, float, float]:
        x, y = self._at(centre)
        reach = radius * self.scale
        return x - reach, y - reach, x + reach, y + reach

    def _near(self, begin: Point, end: Point, length: float) -> tuple[float, float]:
        """Start and end of a line's part in the circle around the canvas, from `begin` [pixels]."""
        if not length:
            return 0.0, 0.0
        ahead = (end[0] - begin[0]) / length, (end[1] - begin[1]) / length
        to_centre = self.width / 2.0 - begin[0], self.height / 2.0 - begin[1]
        along = to_centre[0] * ahead[0] + to_centre[1] * ahead[1]
        aside = to_centre[0] * ahead[1] - to_centre[1] * ahead[0]
        half = math.sqrt(max(0.0, (self.width**2 + self.height**2) / 4.0 - aside * aside))
        return max(0.0, along - half), min(length, along + half)


@contextlib.contextmanager
def drawing(canvas: Canvas, *, smoothing: int = 1) -> Iterator[Pen]:
    """Draw shapes on a canvas; the end of the block puts them on it.

    Args:
        canvas: The canvas.
        smoothing: Factor by which shapes are enlarged and then averaged, for soft edges; 1
            keeps edges hard.

    Yields:
        The pen to draw with.
    """
    image = Image.fromarray(canvas.pixels)
    if smoothing > 1:
        size = (canvas.width * smoothing, canvas.height * smoothing)
        image = image.resize(size, Image.Resampling.NEAREST)
    yield Pen(ImageDraw.Draw(image), smoothing, canvas.width, canvas.height)
    if smoothing > 1:
        # Pillow weighs colours by alpha here, so clear pixels do not darken the edges.
        image = image.reduce(smoothing)
    canvas.pixels[...] = np.asarray(image)


def toward(centre: Point, distance: float, direction: float) -> Point:
    """The point at this distance [pixels] and direction [rad], counter-clockwise from up."""
    return centre[0] - distance * math.sin(direction), centre[1] - distance * math.cos(direction)


def _between(begin: Point, end: Point, share: float) -> Point:
    return begin[0] + (end[0] - begin[0]) * share, begin[1] + (end[1] - begin[1]) * share


def _pillow_angles(direction: float, opening: float) -> tuple[float, float]:
    """Pillow measures degrees clockwise from the right."""
    middle = 270.0 - math.degrees(direction)
    half = math.degrees(opening) / 2.0
    return middle - half, middle + half
