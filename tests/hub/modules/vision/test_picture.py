"""What vision makes of the camera's picture."""

from __future__ import annotations

import numpy as np
import pytest

from hub.errors import RangeError
from hub.gcm.vision import IMAGE_REQUEST, ImageKind, ImageRequest
from hub.modules.vision.picture import brightened, brightness, prepare
from tests.support.cases import for_each


def test_colour_is_the_camera_s_own() -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    assert np.array_equal(prepare(pixels, ImageKind.COLOUR), pixels)


def test_grey_is_the_luma_of_the_colours() -> None:
    colours = [(255, 255, 255), (0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255)]
    grey = prepare(np.array([colours], np.uint8), ImageKind.GREY)
    assert grey.shape == (1, 5)
    # Rec. 601: 0.299, 0.587, 0.114
    assert np.abs(grey[0].astype(float) - [255, 0, 76.2, 149.7, 29.1]).max() <= 1.0


def test_brightness_is_the_mean_luma() -> None:
    pixels = np.zeros((120, 160, 3), np.uint8)
    assert brightness(pixels) == 0.0
    pixels[:60] = 255
    assert brightness(pixels) == pytest.approx(127.5)
    assert brightness(np.full((1, 1, 3), 7, np.uint8)) == pytest.approx(7.0)


def test_brightened_pictures_keep_their_order_and_white() -> None:
    pixels = np.array([[[0, 1, 10], [60, 200, 255]]], np.uint8)
    assert brightened(pixels, 4.0).tolist() == [[[0, 4, 40], [240, 255, 255]]]
    assert brightened(pixels, 1.0) is pixels


@for_each(
    ("request_", "why"),
    [
        (ImageRequest(width_px=0), "width_px is 0, not 1 to "),
        (ImageRequest(height_px=-5), "height_px is -5, not 1 to "),
        (ImageRequest(quality=0), "quality is 0, not 1 to 100"),
        (ImageRequest(quality=101), "quality is 101, not 1 to 100"),
    ],
)
def test_requests_out_of_bounds_are_refused_in_words(request_: ImageRequest, why: str) -> None:
    with pytest.raises(RangeError, match=why):
        IMAGE_REQUEST.decode(b"".join(IMAGE_REQUEST.encode(request_)))


def test_requests_for_more_than_any_camera_has_are_no_mistake() -> None:
    for size, quality in ((2**31 - 1, 100), (1, 1)):
        request = ImageRequest(width_px=size, height_px=size, quality=quality)
        assert IMAGE_REQUEST.decode(b"".join(IMAGE_REQUEST.encode(request))) == request
