"""Pictures as they come from robots: what was coded there is decoded here, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from hub.errors import CodecError
from hub.gcm.vision import Image, ImageCoding
from hub.modules.vision.coding import code
from rune_tui.link.pictures import picture_of
from tests.support.cases import for_each
from tests.support.messages import camera_state

RAMP = np.linspace(0, 255, 24 * 32 * 3).astype(np.uint8).reshape(24, 32, 3)


def image(pixels: np.ndarray, coding: ImageCoding, *, width: int = 32) -> Image:
    data = code(pixels, coding, 95)
    return Image(
        camera=camera_state(),
        coding=coding,
        width_px=width,
        height_px=24,
        channels=3 if pixels.ndim == 3 else 1,
        data=data,
    )


@for_each("coding", ImageCoding)
@for_each("pixels", [RAMP, RAMP[..., 0]])
def test_every_coding_of_the_robot_comes_out_as_it_went_in(
    pixels: np.ndarray, coding: ImageCoding
) -> None:
    shown = picture_of(image(pixels, coding)).pixels
    wanted = pixels if pixels.ndim == 3 else np.repeat(pixels[..., None], 3, axis=2)
    assert shown.shape == wanted.shape
    assert np.abs(shown.astype(int) - wanted).mean() < 4


@pytest.mark.parametrize("coding", [ImageCoding.JPEG, ImageCoding.WEBP])
def test_a_file_of_another_size_or_kind_is_refused(coding: ImageCoding) -> None:
    with pytest.raises(CodecError, match=r"of \(32, 24\) in a picture of 31x24"):
        picture_of(image(RAMP, coding, width=31))
    other = ImageCoding.WEBP if coding is ImageCoding.JPEG else ImageCoding.JPEG
    sent = image(RAMP, other)
    wrong = Image(**{name: getattr(sent, name) for name in Image.__slots__} | {"coding": coding})
    with pytest.raises(CodecError, match=f"the picture is no {coding.name}"):
        picture_of(wrong)
