"""The tables of an arena file that shape the ground, and the height map that they make."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from hub.errors import ArenaError
from hub.sim.arena import load_arena
from hub.sim.arena_file import check_arena
from hub.sim.geometry import Surface
from hub.sim.ground.height_field import HeightField
from tests.hub.sim.ground.grounds import block, field_of, ground_arena
from tests.support.cases import for_each

DECK = "[[deck]]\nat = [1.0, 1.0]\nsize = [2.0, 1.0]\nheight = 0.6\nthickness = 0.1\n"


def heights_along(field: HeightField, y: float, *x: float) -> list[float]:
    return field.heights_at(np.array(x), np.full(len(x), y)).round(6).tolist()


def test_without_tables_of_the_ground_there_is_none() -> None:
    assert ground_arena("").ground is None
    assert ground_arena("[terrain]\ncell = 0.05\n").ground is None
    for name in ("empty", "yellow"):
        assert load_arena(name).ground is None


def test_a_ramp_rises_where_it_says_and_cells_do_not_show() -> None:
    shape = "[[ramp]]\nat = [1.0, 1.0]\nsize = [2.0, 1.0]\nlow = 0.1\nhigh = 0.5\nrises = "
    for rises, x, y in (("east", 1.3, 1.5), ("west", 2.7, 1.5), ("north", 1.5, 1.15)):
        field = field_of(f'{shape}"{rises}"\n')
        assert field.height(x, y) == pytest.approx(0.1 + 0.4 * 0.15, abs=1e-6)
        assert field.height(0.9, 1.5) == field.height(50.0, -50.0) == 0.0
    assert field_of(f'{shape}"south"\n').height(1.5, 1.85) == pytest.approx(0.16, abs=1e-6)


def test_stairs_have_steps_and_a_landing() -> None:
    text = "[[stairs]]\nat = [1.0, 1.0]\nsteps = 3\nrise = 0.2\nrun = 0.25\nlanding = 1.0\n"
    field = field_of(text + 'rises = "west"\n')
    assert heights_along(field, 1.5, 0.9, 1.1, 1.9, 2.1, 2.4, 2.6) == [0.0, 0.6, 0.6, 0.4, 0.2, 0.0]


def test_half_ramps_are_as_steep_as_they_say() -> None:
    tan = math.tan(math.radians(15.0))
    wave = field_of("[[ramps]]\nat = [1.0, 1.0]\ntiles = [2, 1]\ncrossing = false\n")
    wanted = [0.3 * tan, 0.5 * tan, 0.4 * tan, 0.1 * tan]
    assert heights_along(wave, 1.7, 1.3, 1.5, 1.8, 2.3) == pytest.approx(wanted, abs=1e-6)
    crossing = field_of("[[ramps]]\nat = [1.0, 1.0]\ntiles = [1, 1]\n")
    assert heights_along(crossing, 1.2, 1.2, 1.8) == pytest.approx([0.4 * tan, 0.2 * tan], abs=1e-6)


@for_each(("pattern", "highest"), [("flat", 2), ("hill", 5), ("diagonal", 5)])
def test_posts_of_a_stepfield_are_whole_units_high(pattern: str, highest: int) -> None:
    text = f'[[stepfield]]\nat = [1.0, 1.0]\npattern = "{pattern}"\nunit = 0.1\nseed = '
    field, same, other = (field_of(text + f"{seed}\n") for seed in (3, 3, 4))
    middles = 1.05 + 0.1 * np.arange(11)
    posts = field.heights_at(
        middles[None, :] + 0.0 * middles[:, None], middles[:, None] + 0.0 * middles
    )
    assert np.allclose(posts / 0.1, np.round(posts / 0.1), atol=1e-5)
    assert round(posts.max() / 0.1) == highest
    if pattern == "diagonal":
        assert (np.diag(posts) >= 0.4 - 1e-6).all()
    assert (field.heights == same.heights).all()
    assert (field.heights != other.heights).any()


def test_a_pipe_is_round_and_solid_below_and_slippery_where_it_turns() -> None:
    text = "[[pipe]]\nat = [1.0, 1.0]\nlength = 2.0\nradius = 0.1\nheight = 0.3\n"
    field = field_of(text)
    assert field.height(1.1, 2.0) == pytest.approx(0.3, abs=0.002)
    assert field.height(1.0125, 2.0) == pytest.approx(0.2 + math.sqrt(0.01 - 0.0875**2), abs=1e-3)
    grips = field.grip.take(field.cells(np.array([1.1, 0.9]), np.array([2.0, 2.0])))
    assert grips.tolist() == [0.0, 1.0]
    along = field_of(text + 'along = "x"\nturning = false\n')
    assert along.height(2.0, 1.1) == pytest.approx(0.3, abs=0.002)
    assert (along.grip == 1.0).all()


def test_the_highest_element_counts_and_gives_its_appearance() -> None:
    low = block(1.0, 0.2, 2.0) + 'texture = "brick"\ncolour = "red"\n'
    high = block(2.0, 0.4, 2.0) + 'texture = "wood"\ncolour = "blue"\n'
    for text in (low + high, high + low):
        field = field_of(text)
        assert heights_along(field, 1.5, 1.5, 2.5, 3.5) == pytest.approx([0.2, 0.4, 0.4], abs=1e-6)
        seen = field.appearance.take(field.cells(np.array([0.8, 1.5, 2.5]), np.full(3, 1.5)))
        names = [field.surfaces[number].texture for number in seen.tolist()]
        assert names == ["checker", "brick", "wood"]
        assert seen[0] == 0


def test_a_surface_changes_grip_and_appearance_of_all_that_is_there() -> None:
    field = field_of(
        block(1.0, 0.2, 1.0)
        + '[[surface]]\nat = [1.5, 0.0]\nsize = [2.0, 3.0]\ngrip = 0.5\ncolour = "red"\n'
    )
    cells = field.cells(np.array([1.2, 1.8, 3.0]), np.full(3, 1.5))
    assert field.grip.take(cells).tolist() == [1.0, 0.5, 0.5]
    seen = [field.surfaces[number] for number in field.appearance.take(cells).tolist()]
    assert seen[1:] == [Surface(texture=name, colour=(214, 40, 40)) for name in ("wood", "checker")]


def test_a_deck_is_a_second_layer_and_a_box() -> None:
    arena = ground_arena(DECK, (0.5, 0.5))
    field = arena.ground
    assert field is not None
    assert [field.height(2.0, 1.5, below) for below in (-math.inf, 0.5, 0.7)] == pytest.approx(
        [0.0, 0.0, 0.6]
    )
    assert field.height(0.5, 1.5, math.inf) == 0.0
    assert arena.boxes[-1] == field.deck_boxes[0]
    assert (arena.boxes[-1].low, arena.boxes[-1].high) == ((1.0, 1.0, 0.5), (3.0, 2.0, 0.6))


def test_victims_and_signs_stand_on_the_ground_or_on_the_deck() -> None:
    victim = '[[victim]]\nname = "a"\nat = [2.0, 1.5]\nfacing = "east"\npose = "lying"\n'
    wall = "[[wall]]\nfrom = [3.0, 0.0]\nto = [3.0, 3.0]\nheight = 2.0\n"
    sign = '[[landmark]]\nname = "b"\nat = [2.95, 1.5]\nfacing = "west"\ncolour = "red"\n'
    text = block(1.0, 0.3, 2.0)

    def bottoms(text: str) -> tuple[float, float]:
        boxes = ground_arena(text, (0.5, 0.5)).boxes
        people = [box.low[2] for box in boxes if box.surface.texture == "fabric"]
        (panel,) = [box.low[2] for box in boxes if box.picture and box.picture.texture == "sign"]
        return min(people), panel

    assert bottoms(wall + victim + sign) == pytest.approx((0.0, 0.4))
    assert bottoms(text + wall + victim + sign) == pytest.approx((0.3, 0.7))
    assert bottoms(DECK + wall + victim + "deck = true\n" + sign) == pytest.approx((0.6, 0.4))


START = 'name = "a"\n[start]\nat = [0.6, 1.5]\n'
VICTIM = '[[victim]]\nname = "a"\nat = [4.0, 1.5]\nfacing = "east"\ndeck = true\n'
DOOR = "[[wall]]\nfrom = [2.0, 0.0]\nto = [2.0, 3.0]\ndoorways = [{ at = 1.5, height = 0.8 }]\n"


@for_each(
    ("text", "problem"),
    [
        (block(-1.0, 1.5, 1.55), "start: a robot would tip over there"),
        (
            "[[ramp]]\nat = [0.0, 0.0]\nsize = [2.0, 3.0]\nhigh = 0.8\n",
            "start: a robot would lean by 22",
        ),
        (block(0.53, 0.12, 0.15, 1.425, 0.15), "start: the wheels of a robot would hang"),
        (DOOR + block(1.5, 0.5), "wall 1: doorway 1: the ground leaves only 0.30 m"),
        (VICTIM + DECK, "victim 1, key 'deck': there is no deck"),
        (
            block(0.2, 0.3) + "[[box]]\nat = [0.6, 1.5]\nsize = [0.1, 0.1, 0.5]\n",
            "would touch box 1",
        ),
    ],
)
def test_mistakes_of_the_ground_are_reported_at_load(
    tmp_path: Path, text: str, problem: str
) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(START + text)
    with pytest.raises(ArenaError) as caught:
        load_arena(str(path))
    assert problem in str(caught.value)


@for_each(
    ("text", "problem"),
    [
        ("[[ramp]]\nat = [0, 0]\nsize = [1, 1]\n", "ramp 1: key 'high' is missing"),
        ("[[ramps]]\nat = [0, 0]\ntiles = [1.5, 2]\n", "ramps 1, key 'tiles': 1.5 is not a whole"),
        ("[[stairs]]\nat = [0, 0]\nrises = 'up'\n", "stairs 1, key 'rises': 'up' is none of"),
        ("[[stepfields]]\n", "unknown table or key 'stepfields'; did you mean 'stepfield'?"),
        (
            "[terrain]\ncell = 0.01\n" + block(0.0, 0.1) + block(40.0, 0.1, y=40.0),
            "cells are more than the 4000000 allowed; make key 'cell' larger",
        ),
        ("[scoring]\nweight = -1\n", "scoring, key 'weight': -1 is not between 0 and 10"),
    ],
)
def test_mistakes_in_tables_of_the_ground_have_their_place(text: str, problem: str) -> None:
    assert problem in "\n".join(check_arena(tomllib.loads(START + text))[1])
