"""Pictures as bytes, in each coding."""

from __future__ import annotations

import io
import sys

import numpy as np
import pytest
from PIL import Image

from hub.errors import HandlerFailedError
from hub.gcm import rle
from hub.gcm.vision import ImageCoding
from hub.modules.vision.coding import code
from tests.support.cases import for_each

COLOUR = np.zeros((30, 40, 3), np.uint8)
COLOUR[:, :20] = (200, 40, 40)
COLOUR[10:, 20:] = (40, 40, 200)
FILES = [ImageCoding.JPEG, ImageCoding.WEBP]
GREY = np.ascontiguousarray(COLOUR[..., 0])


@pytest.mark.parametrize("pixels", [COLOUR, GREY, COLOUR[:, ::2]], ids=["colour", "grey", "view"])
def test_raw_is_the_values_themselves(pixels: np.ndarray) -> None:
    data = code(pixels, ImageCoding.RAW, 1)
    assert data.shape == (pixels.size,)
    assert np.array_equal(data.reshape(pixels.shape), pixels)


@pytest.mark.parametrize("pixels", [COLOUR, GREY], ids=["colour", "grey"])
def test_run_lengths_are_exact_at_full_quality(pixels: np.ndarray) -> None:
    data = code(pixels, ImageCoding.RLE, 100)
    back = rle.decode(data, 30, 40, 1 if pixels.ndim == 2 else 3)
    assert np.array_equal(back.reshape(pixels.shape), pixels)


@for_each("coding", FILES)
@for_each("pixels", [COLOUR, GREY, COLOUR[:, ::2]])
def test_a_file_is_one_that_others_read(pixels: np.ndarray, coding: ImageCoding) -> None:
    data = code(pixels, coding, 90)
    assert (data.dtype, data.ndim) == (np.uint8, 1)
    with Image.open(io.BytesIO(data.tobytes())) as file:
        assert file.format == coding.name
        back = np.asarray(file.convert("L" if pixels.ndim == 2 else "RGB"))
    assert back.shape == pixels.shape
    assert np.abs(back.astype(int) - pixels).mean() < 8


@pytest.mark.parametrize("coding", FILES)
def test_less_quality_makes_shorter_files(coding: ImageCoding) -> None:
    noisy = np.random.default_rng(1).integers(0, 256, (60, 80, 3), dtype=np.uint8)
    lengths = [len(code(noisy, coding, quality)) for quality in (1, 30, 60, 90, 100)]
    assert lengths == sorted(set(lengths))


@pytest.mark.parametrize("coding", FILES)
def test_without_pillow_files_are_refused_with_what_to_install(
    monkeypatch: pytest.MonkeyPatch, coding: ImageCoding
) -> None:
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(HandlerFailedError, match=r"pip install 'robot-user-nexus\[camera\]'"):
        code(COLOUR, coding, 60)
    assert len(code(COLOUR, ImageCoding.RLE, 60))


def test_a_pillow_that_cannot_do_it_is_told_from_none(monkeypatch: pytest.MonkeyPatch) -> None:
    Image.init()
    monkeypatch.delitem(Image.SAVE, "WEBP")
    with pytest.raises(HandlerFailedError, match="as WEBP here: Pillow cannot do it"):
        code(COLOUR, ImageCoding.WEBP, 60)
    assert len(code(COLOUR, ImageCoding.JPEG, 60))
