"""visualizePanData and visualizeTiltData."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK
from rune_tui.visualizers.video.angle_bars import PanData, TiltData, bar_span

PAN, TILT = "visualizePanData", "visualizeTiltData"


def with_camera(made, age: float = 0.1, **changes):
    return made.robot(camera=made.received(made.camera(**changes), age))


def bar(line: np.ndarray) -> list[int]:
    """Places along the line that show the bar (or the centre line on it)."""
    blue = (line[:, 2].astype(int) - line[:, 0] > 60).nonzero()[0]
    return [int(blue.min()), int(blue.max())]


def test_straight_ahead_the_bar_lies_across_the_centre(made, draw, golden) -> None:
    canvas = draw(PAN, with_camera(made), (40, 2))
    first, last = bar(canvas.pixels[0])
    assert first + last == 39
    # 0.8 rad of 2 * 1.6 + 0.8.
    assert last - first + 1 == 8
    assert (canvas.pixels[:, 19:21] == DARK.ink).all()
    golden("pan_data", canvas)


def test_left_pan_is_drawn_left_and_right_pan_right(made, draw) -> None:
    _, last = bar(draw(PAN, with_camera(made, pan=0.9), (40, 2)).pixels[0])
    assert last < 19
    first, _ = bar(draw(PAN, with_camera(made, pan=-0.9), (40, 2)).pixels[0])
    assert first > 20


def test_up_is_drawn_at_the_top(made, draw, golden) -> None:
    canvas = draw(TILT, with_camera(made, tilt=0.5), (2, 16))
    first, last = bar(canvas.pixels[:, 0])
    assert first == 0
    assert last < 7
    golden("tilt_data", canvas)


@pytest.mark.parametrize("sign", [1, -1])
def test_at_its_limit_the_bar_touches_the_end(made, draw, sign) -> None:
    span = bar(draw(PAN, with_camera(made, pan=sign * 1.6), (40, 2)).pixels[0])
    assert span == ([0, 7] if sign > 0 else [32, 39])


def test_zooming_in_makes_the_bar_shorter(made, draw) -> None:
    wide = bar(draw(PAN, with_camera(made), (80, 2)).pixels[0])
    tele = bar(draw(PAN, with_camera(made, horizontal_fov=0.2), (80, 2)).pixels[0])
    assert tele[1] - tele[0] < wide[1] - wide[0]


@given(
    st.integers(1, 300),
    st.floats(-5, 5),
    st.floats(0, 3),
)
def test_the_bar_is_never_empty_nor_outside(length: int, offset: float, share: float) -> None:
    start, end = bar_span(length, offset, share)
    assert 0 <= start < end <= length


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_an_unknown_angle_draws_no_bar(made, draw, value) -> None:
    canvas = draw(PAN, with_camera(made, pan=value), (40, 2))
    assert (canvas.pixels == canvas.pixels[0, 0]).all()


def test_without_a_camera_the_bar_is_empty(made, draw) -> None:
    for name in (PAN, TILT):
        canvas = draw(name, made.robot(camera=None), (12, 12))
        assert (canvas.pixels == canvas.pixels[0, 0]).all()


def test_an_old_angle_is_dimmed_and_then_marked(made, draw) -> None:
    fresh, old, stale = (draw(PAN, with_camera(made, age), (40, 2)) for age in (0.1, 2.0, 4.0))
    assert old.pixels[..., :3].max() < fresh.pixels[..., :3].max()
    assert not old.glyphs.any()
    assert "STALE 4.0 s" in "".join(chr(p or 32) for p in stale.glyphs[0])


@pytest.mark.parametrize(("shown", "angle"), [(PanData(), "pan"), (TiltData(), "tilt")])
def test_the_token_changes_with_the_angle_and_not_with_every_message(made, shown, angle) -> None:
    state = ConsoleState(now=made.now)
    first = shown.source(with_camera(made), state)
    assert first == shown.source(with_camera(made, stamp=9.0), state)
    assert first != shown.source(with_camera(made, **{angle: 0.1}), state)
    assert first != shown.source(with_camera(made, age=1.5), state)
