"""Which pictures are asked for on which link."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.vision import ImageCoding, ImageKind, ImageRequest
from rune_tui.link.picture_choice import LEAST_WIDTH_PX, START, STEPS, PictureChoice
from rune_tui.model.console_state import PictureWish
from tests.support.cases import for_each

SIZE = (160, 96)
USUAL = PictureWish()
HEADERS = 350.0
"""What goes with each picture [bytes]."""


def size_of(request: ImageRequest) -> float:
    """About how many bytes the answer has: as the table of steps says, twice as many as JPEG."""
    if request.coding is ImageCoding.RLE and request.quality == USUAL.quality:
        return HEADERS + 330.0 * STEPS[-1].size
    step = next(s for s in STEPS if s.quality == request.quality and not s.exact)
    scale = request.width_px / SIZE[0]
    many = 2.0 if request.coding is ImageCoding.JPEG else 1.0
    full = next(s.size for s in STEPS if s.quality == step.quality and s.scale == 1.0)
    return HEADERS + many * 330.0 * full * scale**1.5


def settle(
    choice: PictureChoice, bytes_per_s: float, *, work: float = 0.008, seconds: float = 60.0
) -> ImageRequest:
    """What is asked for at the end of so long on a link of this rate and a robot this slow [s]."""
    now = 0.0
    while now < seconds:
        request = choice.request(SIZE, USUAL)
        service = work + size_of(request) / bytes_per_s
        now += max(0.066, service)
        choice.answered(request, service, now)
    return choice.request(SIZE, USUAL)


def test_a_fast_link_gets_run_lengths_of_the_whole_size() -> None:
    wide = settle(PictureChoice(), 10e6)
    assert (wide.coding, wide.quality, wide.width_px) == (ImageCoding.RLE, 60, 160)


def test_a_slow_robot_on_a_fast_link_is_not_taken_for_a_thin_link() -> None:
    wide = settle(PictureChoice(), 10e6, work=0.06)
    assert wide.quality >= 60
    assert wide.width_px == 160


def test_the_thinner_the_link_the_less_quality_then_rate_and_size_last() -> None:
    asked = [settle(PictureChoice(), rate) for rate in (10e6, 100e3, 20e3, 8e3, 5e3, 2e3, 200.0)]
    sizes = [size_of(request) for request in asked]
    assert sizes == sorted(sizes, reverse=True)
    assert [request.width_px for request in asked[:5]] == [160] * 5
    assert {request.coding for request in asked[1:]} == {ImageCoding.WEBP}
    assert asked[2].quality >= 20
    # Five pictures a second of the whole size do not fit any more.
    assert asked[-1].width_px < 160


@given(st.floats(10.0, 1e8), st.floats(0.0, 0.5), st.integers(1, 4000), st.integers(1, 4000))
def test_no_link_is_so_thin_that_pictures_become_useless(
    rate: float, work: float, width: int, height: int
) -> None:
    choice = PictureChoice()
    settle(choice, rate, work=work, seconds=20.0)
    request = choice.request((width, height), USUAL)
    assert min(width, LEAST_WIDTH_PX) <= request.width_px <= width
    assert 1 <= request.height_px <= height
    assert abs(request.width_px * height - request.height_px * width) <= max(width, height)


def test_the_first_picture_is_small_enough_for_any_link() -> None:
    first = PictureChoice().request(SIZE, USUAL)
    assert (first.coding, first.quality) == (ImageCoding.WEBP, STEPS[START].quality)


def test_a_link_that_becomes_thin_and_wide_again_is_followed() -> None:
    choice = PictureChoice()
    assert settle(choice, 10e6).coding is ImageCoding.RLE
    thin = settle(choice, 8e3, seconds=20.0)
    assert size_of(thin) < 1000.0
    assert settle(choice, 10e6, seconds=200.0).coding is ImageCoding.RLE


def test_a_step_that_was_too_much_is_tried_less_and_less_often() -> None:
    choice, now, tried, before = PictureChoice(), 0.0, [], 0.0
    while now < 300.0:
        request = choice.request(SIZE, USUAL)
        service = 0.008 + size_of(request) / 50e3
        now += 0.066
        choice.answered(request, service, now)
        size = size_of(choice.request(SIZE, USUAL))
        if size > before:
            tried.append(now)
        before = size
    pauses = [later - sooner for sooner, later in itertools.pairwise(tried)]
    assert max(pauses) > 60.0
    assert len(tried) < 15


def test_a_robot_without_webp_is_asked_for_jpeg_and_without_both_for_run_lengths() -> None:
    choice = PictureChoice()
    codings = []
    for _ in range(3):
        request = choice.request(SIZE, USUAL)
        codings.append(request.coding)
        choice.refused(request)
    assert codings == [ImageCoding.WEBP, ImageCoding.JPEG, ImageCoding.RLE]
    # Run lengths can be coded everywhere: it was the camera that failed.
    assert choice.request(SIZE, USUAL).coding is ImageCoding.WEBP


def test_an_answer_that_does_not_come_makes_the_next_smaller() -> None:
    choice = PictureChoice()
    first = size_of(choice.request(SIZE, USUAL))
    choice.timed_out(1.0)
    assert size_of(choice.request(SIZE, USUAL)) < first
    for _ in range(20):
        choice.timed_out(2.0)
    assert choice.request(SIZE, USUAL).width_px == 80


@for_each("coding", ImageCoding)
def test_a_coding_that_the_layout_asks_for_is_not_changed(coding: ImageCoding) -> None:
    wish = PictureWish(coding=coding, quality=33, width=90, kind=ImageKind.GREY)
    request = PictureChoice().request(SIZE, wish)
    wanted = ImageRequest(kind=ImageKind.GREY, width_px=90, height_px=96, quality=33, coding=coding)
    assert request == wanted
