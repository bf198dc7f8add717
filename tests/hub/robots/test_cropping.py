"""Pictures of another shape than the camera's."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.robots.cropping import cropped_fov, scaled_size, size_within, vertical_fov

SIZE = st.tuples(st.integers(1, 5000), st.integers(1, 5000))


@given(asked=st.tuples(st.integers(), st.integers()), whole=SIZE)
def test_no_picture_is_larger_than_the_camera_s_or_empty(
    asked: tuple[int, int], whole: tuple[int, int]
) -> None:
    size = size_within(*asked, whole)
    assert 1 <= size[0] <= whole[0]
    assert 1 <= size[1] <= whole[1]


@given(size=SIZE, whole=SIZE)
def test_the_scaled_picture_covers_what_is_cut_from_it_with_square_pixels(
    size: tuple[int, int], whole: tuple[int, int]
) -> None:
    scaled = scaled_size(size, whole)
    assert scaled[0] >= size[0]
    assert scaled[1] >= size[1]
    assert size[0] == scaled[0] or size[1] == scaled[1]
    scale = max(size[0] / whole[0], size[1] / whole[1])
    assert abs(scaled[0] - whole[0] * scale) <= 1.0
    assert abs(scaled[1] - whole[1] * scale) <= 1.0


@given(fov=st.floats(0.05, 3.0), size=SIZE, whole=SIZE)
def test_a_narrower_picture_sees_less_of_the_width(
    fov: float, size: tuple[int, int], whole: tuple[int, int]
) -> None:
    seen = cropped_fov(fov, size, whole)
    if size[0] * whole[1] >= whole[0] * size[1]:
        assert seen == fov
    else:
        # The focal length in pixels of the scaled picture is the same for both.
        share = size[0] * whole[1] / (size[1] * whole[0])
        assert math.tan(seen / 2) == pytest.approx(math.tan(fov / 2) * share)


def test_the_height_of_a_picture_is_three_quarters_of_its_width() -> None:
    assert math.tan(vertical_fov(1.0) / 2) == pytest.approx(0.75 * math.tan(0.5))
