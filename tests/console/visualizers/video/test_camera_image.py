"""visualizeCameraImage."""

from __future__ import annotations

import numpy as np
import pytest

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.video.camera_image import CameraImage
from rune_tui.visualizers.video.picture_frame import FILL, FIT

NAME = "visualizeCameraImage"


def text(canvas) -> str:
    lines = ("".join(chr(p or 32) for p in row).strip() for row in canvas.glyphs.tolist())
    return " ".join(line for line in lines if line)


def test_a_fresh_picture_is_fitted_with_its_aspect_kept(made, draw, golden) -> None:
    canvas = draw(NAME, made.robot(), (14, 6))
    assert (canvas.pixels[:, 3:11, :3] == made.picture().pixels).all()
    assert (canvas.pixels[:, :3, :3] == 0).all()
    assert (canvas.pixels[..., 3] == 255).all()
    assert text(canvas) == ""
    golden("camera_image", canvas)


@pytest.mark.parametrize(("age", "dimmed"), [(0.99, False), (1.01, True), (2.99, True)])
def test_a_picture_older_than_a_second_is_dimmed_without_words(made, draw, age, dimmed) -> None:
    fresh = draw(NAME, made.robot(), (40, 30)).pixels[..., :3]
    canvas = draw(NAME, made.robot(picture=made.received(made.picture(), age)), (40, 30))
    assert (canvas.pixels[..., :3].max() < fresh.max() * 0.6) == dimmed
    # Evenly: pixels that were equal still are.
    assert (canvas.pixels[3, :18] == canvas.pixels[3, 0]).all()
    assert text(canvas) == ""


def test_a_picture_older_than_three_seconds_is_hatched_and_marked(made, draw, golden) -> None:
    old = draw(NAME, made.robot(picture=made.received(made.picture(), 2.0)), (20, 16))
    stale = draw(NAME, made.robot(picture=made.received(made.picture(), 4.25)), (20, 16))
    assert text(stale) == "STALE 4.2 s"
    below = slice(2, None)
    darker = (stale.pixels[below] < old.pixels[below]).any(axis=2)
    assert 0.2 < darker.mean() < 0.5
    assert (stale.pixels[below][~darker] == old.pixels[below][~darker]).all()
    golden("camera_image_stale", stale)


def test_before_the_first_picture_words_say_what_is_awaited(made, draw) -> None:
    canvas = draw(NAME, made.robot(picture=None), (60, 20))
    assert text(canvas) == "waiting for the first picture from magellan"


@pytest.mark.parametrize("picture", [True, False])
def test_a_lost_link_is_said_in_words_in_place_of_a_picture_only(made, draw, picture) -> None:
    parts = {} if picture else {"picture": None}
    canvas = draw(NAME, made.robot(link=made.link(LinkPhase.LOST), **parts), (80, 20))
    told = "no link to magellan at tcp://10.0.0.5:1381: retrying, 3 s"
    assert text(canvas) == ("" if picture else told)  # else the banner tells


def test_the_last_failure_is_told(made, draw) -> None:
    link = made.link(LinkPhase.LOST, detail="the hub refused the name")
    canvas = draw(NAME, made.robot(link=link, picture=None), (50, 20))
    assert text(canvas).endswith("retrying, 3 s; the hub refused the name")


def test_a_link_not_made_yet_is_called_connecting(made, draw) -> None:
    link = made.link(LinkPhase.CONNECTING)
    canvas = draw(NAME, made.robot(picture=None, link=link), (60, 20))
    assert text(canvas) == "connecting to magellan at tcp://10.0.0.5:1381: 3 s"


def test_a_picture_without_pixels_counts_as_none(made, draw) -> None:
    empty = made.picture()
    object.__setattr__(empty, "pixels", np.zeros((0, 0, 3), np.uint8))
    draw(NAME, made.robot(picture=made.received(empty)), (20, 10))


def test_the_token_changes_with_the_picture_and_the_look_of_its_age(made) -> None:
    shown = CameraImage()

    def token(age: float, number: int = 1):
        robot = made.robot(picture=made.received(made.picture(), age, number))
        return shown.source(robot, ConsoleState(now=made.now))

    assert token(0.1) == token(0.9)
    assert token(0.1) != token(0.1, number=2)
    assert token(0.9) != token(1.1)
    assert token(1.1) == token(2.9)
    assert token(2.9) != token(3.1)
    assert token(3.11) == token(3.18)
    assert token(3.1) != token(3.3)


def test_the_token_changes_with_the_words(made) -> None:
    shown = CameraImage()
    robot = made.robot(picture=None, link=made.link(LinkPhase.LOST))
    first = shown.source(robot, ConsoleState(now=made.now))
    assert first == shown.source(robot, ConsoleState(now=made.now + 0.3))
    assert first != shown.source(robot, ConsoleState(now=made.now + 1.0))


def for_quadrants(made, size: tuple[int, int], age: float = 0.1, fit: str = FIT) -> Canvas:
    canvas = Canvas.blank(*size, scale=(2, 1))
    robot = made.robot(picture=made.received(made.picture(), age))
    CameraImage(fit=fit).draw(canvas, robot, ConsoleState(now=made.now))
    return canvas


def test_for_quadrants_the_picture_lies_in_the_same_place_with_more_pixels(made, draw) -> None:
    canvas, plain = for_quadrants(made, (10, 3)), draw(NAME, made.robot(), (10, 3))
    # Eight pixels across the picture in four of the canvas; the viewport has bars beside it.
    (placed,) = canvas.pictures
    assert (placed.x, placed.y, placed.pixels.shape) == (3, 0, (3, 8, 4))
    assert (placed.pixels[[0, 2], :, :3] == made.picture().pixels[[0, 5]]).all()
    assert not plain.pictures
    assert np.abs(canvas.pixels.astype(int) - plain.pixels).max() <= 1


def test_a_picture_with_more_pixels_is_cut_like_any_other(made, draw) -> None:
    canvas = for_quadrants(made, (16, 4), fit=FILL)
    plain = draw(NAME, made.robot(), (16, 4), fit=FILL)
    assert canvas.pictures[0].pixels.any()
    assert np.abs(canvas.pixels.astype(int) - plain.pixels).max() <= 30


def test_what_is_drawn_over_a_picture_with_more_pixels_is_drawn_as_without(made, draw) -> None:
    stale = made.received(made.picture(), 4.25)
    canvas = for_quadrants(made, (20, 16), 4.25)
    plain = draw(NAME, made.robot(picture=stale), (20, 16))
    assert (canvas.glyphs == plain.glyphs).all()
    assert np.abs(canvas.pixels.astype(int) - plain.pixels).max() <= 1
