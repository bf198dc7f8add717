"""What vision makes of the camera's picture."""

from __future__ import annotations

import numpy as np

from hub.gcm.vision import ImageKind
from hub.modules.vision.picture import prepare


def test_colour_is_the_camera_s_own() -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    assert np.array_equal(prepare(pixels, ImageKind.COLOUR), pixels)


def test_grey_is_the_luma_of_the_colours() -> None:
    colours = [(255, 255, 255), (0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255)]
    grey = prepare(np.array([colours], np.uint8), ImageKind.GREY)
    assert grey.shape == (1, 5)
    # Rec. 601: 0.299, 0.587, 0.114
    assert np.abs(grey[0].astype(float) - [255, 0, 76.2, 149.7, 29.1]).max() <= 1.0
