"""Lines, rectangles, circles, pies and polygons on a canvas, rasterised by Pillow."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from rune_tui.raster.canvas import Canvas, Colour

Point = tuple[float, float]
"""x right, y down from the upper left corner of the canvas [pixels]; pixel (0, 0) spans 0 to 1."""


@dataclass(frozen=True, slots=True)
class Pen:
    """Draws in canvas coordinates; every shape replaces the pixels it covers, alpha included.

    Attributes:
        draw: Pillow's drawing on the enlarged picture.
        scale: How many of its pixels make one of the canvas.
    """

    draw: ImageDraw.ImageDraw
    scale: int

    def line(self, points: Sequence[Point], colour: Colour, width: float = 1.0) -> None:
        """Join points by straight lines `width` pixels thick."""
        thickness = max(1, round(width * self.scale))
        self.draw.line([self._at(point) for point in points], colour, thickness, joint="curve")

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
        self.draw.ellipse(self._box(centre, radius), fill, rim, self.scale if rim else 0)

    def pie(
        self, centre: Point, radius: float, direction: float, opening: float, fill: Colour
    ) -> None:
        """A filled slice of a circle.

        Args:
            centre: Its tip.
            radius: How far it reaches [pixels].
            direction: Where its middle points [rad], counter-clockwise from up.
            opening: Its angle [rad].
            fill: Its colour.
        """
        start, end = _pillow_angles(direction, opening)
        if radius > 0.0:
            self.draw.pieslice(self._box(centre, radius), start, end, fill)

    def arc(
        self, centre: Point, radius: float, direction: float, opening: float, colour: Colour
    ) -> None:
        """The rim of a pie, one pixel thick, inwards of `radius`; arguments as for `pie`."""
        start, end = _pillow_angles(direction, opening)
        if radius > 0.0:
            self.draw.arc(self._box(centre, radius), start, end, colour, self.scale)

    def _at(self, point: Point) -> Point:
        return point[0] * self.scale, point[1] * self.scale

    def _box(self, centre: Point, radius: float) -> tuple[float, float, float, float]:
        x, y = self._at(centre)
        reach = radius * self.scale
        return x - reach, y - reach, x + reach, y + reach


@contextlib.contextmanager
def drawing(canvas: Canvas, *, smoothing: int = 1) -> Iterator[Pen]:
    """Draw shapes on a canvas; they are on it when the block ends.

    Args:
        canvas: What to draw on.
        smoothing: Shapes are drawn this many times larger and averaged down, so that edges
            become soft; 1 leaves them hard.

    Yields:
        The pen to draw with.
    """
    image = Image.fromarray(canvas.pixels)
    if smoothing > 1:
        size = (canvas.width * smoothing, canvas.height * smoothing)
        image = image.resize(size, Image.Resampling.NEAREST)
    yield Pen(ImageDraw.Draw(image), smoothing)
    if smoothing > 1:
        # Pillow weighs colours by alpha here, so clear pixels do not darken the edges.
        image = image.reduce(smoothing)
    canvas.pixels[...] = np.asarray(image)


def toward(centre: Point, distance: float, direction: float) -> Point:
    """The point at this distance [pixels] and direction [rad], counter-clockwise from up."""
    return centre[0] - distance * math.sin(direction), centre[1] - distance * math.cos(direction)


def _pillow_angles(direction: float, opening: float) -> tuple[float, float]:
    """Pillow measures degrees clockwise from the right."""
    middle = 270.0 - math.degrees(direction)
    half = math.degrees(opening) / 2.0
    return middle - half, middle + half
