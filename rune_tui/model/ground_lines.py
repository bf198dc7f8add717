"""Lines on the ground in the camera's picture, cut at its edges."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.sightings import Floats


def visible_lines(
    geometry: PictureGeometry, points: npt.ArrayLike, *, margin: float = 0.0
) -> list[Floats]:
    """The visible pieces of lines on the ground.

    Segments are cut in space, before the division by the depth, so that ends behind the camera are
    valid (Liang and Barsky 1984).

    Args:
        geometry: The picture and its camera.
        points: Corners of the lines in the robot's frame [m], shape (n, 2); a row of NaN ends one
            line, and the next row begins another.
        margin: Width around the picture in which lines are kept [px], for thick lines.

    Returns:
        Pieces in picture coordinates [px], each of shape (at least 2, 2), in the lines' order.
    """
    rays = geometry.rays(points)
    if len(rays) < 2:
        return []
    depth, left, up = rays.T
    wide = geometry.half_width * (1.0 + 2.0 * margin / geometry.width) * depth
    high = geometry.half_height * (1.0 + 2.0 * margin / geometry.height) * depth
    inward = np.stack((wide - left, wide + left, high - up, high + up))
    first, last = inward[:, :-1], inward[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = first / (first - last)
    begin = np.where(first < 0.0, crossing, 0.0).max(axis=0)
    end = np.where(last < 0.0, crossing, 1.0).min(axis=0)
    outside = ((first < 0.0) & (last < 0.0)).any(axis=0)
    kept = np.flatnonzero(~outside & np.isfinite(first + last).all(axis=0) & (begin < end))
    if not len(kept):
        return []
    begin, end = begin[kept], end[kept]
    step = rays[kept + 1] - rays[kept]
    starts = geometry.pixels_of_rays(rays[kept] + step * begin[:, None])
    ends = geometry.pixels_of_rays(rays[kept] + step * end[:, None])
    # A piece continues if the next segment begins inside the picture.
    joined = (np.diff(kept) == 1) & (begin[1:] == 0.0)
    breaks = np.flatnonzero(~joined) + 1
    return [
        np.concatenate((start[:1], piece))
        for start, piece in zip(np.split(starts, breaks), np.split(ends, breaks), strict=True)
    ]
