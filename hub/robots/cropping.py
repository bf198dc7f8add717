"""Pictures of another shape than the camera's: the middle of its view, with square pixels."""

from __future__ import annotations

import math

Size = tuple[int, int]
"""Width and height [px]."""


def size_within(width_px: int, height_px: int, whole: Size) -> Size:
    """The size of the answer to a request: the requested one, at most the camera's own."""
    return max(1, min(width_px, whole[0])), max(1, min(height_px, whole[1]))


def cropped_fov(horizontal_fov: float, size: Size, whole: Size) -> float:
    """Field of view from left to right of a picture [rad].

    A narrower picture than the camera's shows the whole height and the middle of the width; a
    wider one shows the whole width.

    Args:
        horizontal_fov: The camera's own [rad].
        size: Of the picture.
        whole: Of the camera's own picture.
    """
    share = size[0] * whole[1] / (size[1] * whole[0])
    if share >= 1.0:
        return horizontal_fov
    return 2.0 * math.atan(math.tan(horizontal_fov / 2.0) * share)


def scaled_size(size: Size, whole: Size) -> Size:
    """The least size of the camera's whole picture from which `size` can be cut."""
    scale = max(size[0] / whole[0], size[1] / whole[1])
    return max(size[0], round(whole[0] * scale)), max(size[1], round(whole[1] * scale))


def vertical_fov(horizontal_fov: float) -> float:
    """Field of view from top to bottom of a 4:3 picture [rad]."""
    return 2.0 * math.atan(math.tan(horizontal_fov / 2.0) * 3.0 / 4.0)
