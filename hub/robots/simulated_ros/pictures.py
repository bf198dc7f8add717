"""Pictures as JPEG files, as drivers of cameras for ROS send them; needs Pillow."""

from __future__ import annotations

import importlib.util
import io
from typing import Final

import numpy as np
import numpy.typing as npt

_QUALITY: Final = 80


def can_compress() -> bool:
    """Whether Pillow is installed."""
    return importlib.util.find_spec("PIL") is not None


def jpeg_file(pixels: npt.NDArray[np.uint8]) -> bytes:
    """The file of a picture, shape (height, width, 3)."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "JPEG", quality=_QUALITY)
    return file.getvalue()
