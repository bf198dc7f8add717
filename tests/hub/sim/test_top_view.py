"""Pictures of arenas from above: what is where, and what hides what."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hub.sim.arena import Arena
from hub.sim.top_view import draw_top_view
from hub.sim.top_view_canvas import Canvas
from tests.hub.sim.arenas import arena_of
from tests.hub.sim.camera.rough_ground import rough_ground

FRAME = 'name="a"\n[start]\nat=[-4,-4]\n[hall]\nfloor_colour="grey"\n'
CORNERS = "".join(f"[[box]]\nat=[{x},{y}]\nsize=[0.8,0.8,0.1]\n" for x, y in ((-5, -5), (5, 5)))
"""The picture reaches from -6 to 6 in x and in y."""


def arena(text: str) -> Arena:
    return arena_of(FRAME + CORNERS + text)


def at(picture: np.ndarray, x: float, y: float) -> np.ndarray:
    """The colour at a place of the arena."""
    size = len(picture)
    return picture[int((6.0 - y) / 12.0 * size), int((x + 6.0) / 12.0 * size)].astype(int)


def drawn(text: str, **others: object) -> np.ndarray:
    return draw_top_view(replace(arena(text), **others), longest_px=240)


def test_solids_have_their_colour_where_they_stand_and_north_is_up() -> None:
    picture = drawn(
        '[[box]]\nat=[2,3]\nsize=[1,1,1]\ncolour="red"\n'
        '[[cylinder]]\nat=[-2,1]\nradius=0.5\nheight=1\ncolour="blue"\n'
    )
    assert picture.shape == (240, 240, 3)
    red, blue = at(picture, 2.0, 3.0), at(picture, -2.0, 1.0)
    assert red[0] > 150 > 80 > red[1]
    assert blue[2] > 150 > 120 > blue[0]
    assert np.ptp(at(picture, 3.5, -2.5)) < 4


def test_what_hangs_above_the_robot_is_see_through_and_higher_solids_hide_lower_ones() -> None:
    low = '[[box]]\nat=[0,0]\nsize=[2,2,0.3]\ncolour="green"\n'
    high = '[[box]]\nat=[0,0]\nsize=[1,1,0.2]\nbase={}\ncolour="red"\n'
    hanging, standing = (at(drawn(high.format(base) + low), 0.1, 0.1) for base in (0.9, 0.3))
    assert standing[0] > 3 * standing[1]
    assert hanging[0] < 2 * hanging[1]


def test_what_stands_on_a_deck_does_not_hang() -> None:
    deck = "[[deck]]\nat=[-1,-1]\nsize=[2,2]\nheight=1.0\n"
    box = '[[box]]\nat=[0,0]\nsize=[1,1,0.3]\nbase={}\ncolour="red"\n'
    alone, on_deck = drawn(box.format(1.0)), drawn(deck + box.format(1.0))
    assert at(on_deck, 0.1, 0.1)[0] > 3 * at(on_deck, 0.1, 0.1)[1]
    assert at(alone, 0.1, 0.1)[0] < 2.5 * at(alone, 0.1, 0.1)[1]


def test_water_colours_what_is_below_its_surface_only() -> None:
    boxes = (
        '[[box]]\nat=[-2,0]\nsize=[1,1,0.5]\ncolour="white"\n'
        '[[box]]\nat=[2,0]\nsize=[1,1,2]\ncolour="white"\n'
    )
    water = "[water]\nsurface=1.0\narea=[[-5,-5],[5,5]]\n"
    dry, wet = drawn(boxes), drawn(boxes + water)
    assert (at(dry, 2.0, 0.0) == at(wet, 2.0, 0.0)).all()
    assert np.abs(at(dry, -2.0, 0.0) - at(wet, -2.0, 0.0)).max() > 40
    assert np.abs(at(dry, 0.0, 3.5) - at(wet, 0.0, 3.5)).max() > 20


def test_start_berths_victims_and_signs_are_marked() -> None:
    text = (
        '[[berth]]\nrobot="blimp"\nat=[3,3]\nheight=1\n'
        '[[landmark]]\nname="l"\nat=[0,0]\nfacing="east"\ncolour="violet"\n'
        '[[ring]]\nat=[0,3]\nfacing="east"\ngap_mm=10\ngap="up"\n'
    )
    picture = draw_top_view(arena(text), [(3.0, -3.0)], 480)
    start, berth, sign = (at(picture, *place) for place in ((-4.0, -3.87), (3.1, 3.0), (0.17, 0.0)))
    assert start[1] > start[0] + 40
    assert berth[2] > berth[0] + 100
    assert sign[2] > sign[1] + 60
    assert at(picture, 0.16, 3.0).min() > 200
    victim = picture[355:366, 355:366].reshape(-1, 3).astype(int)
    assert (victim[:, 0] - victim[:, 1]).max() > 120
    assert victim.min(axis=1).max() > 200


def test_rough_ground_is_drawn_by_its_cells() -> None:
    picture = drawn("", ground=rough_ground((-5.0, -5.0)))
    level, stairs = at(picture, -3.5, 3.5), at(picture, 2.4, -0.6)
    assert np.ptp(level) < 4
    assert stairs[2] > stairs[0]
    posts = picture[100:150, 60:100].reshape(-1, 3).mean(axis=1)
    assert posts.std() > 5.0


def test_digits_are_upright() -> None:
    canvas = Canvas((0.0, 0.0), (1.0, 1.0), 40, (0.0, 0.0, 0.0))
    canvas.text("7", (0.5, 0.5), 0.5, (255.0, 255.0, 255.0))
    picture = canvas.picture()[..., 0]
    # A bar on top, and a stroke at the right below it.
    assert (picture[12, 15:25] > 128).all()
    assert (picture[26, 22:25] > 128).all()
    assert (picture[26, 15:20] < 128).all()
