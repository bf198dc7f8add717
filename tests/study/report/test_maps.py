"""Maps are well-formed and light, and say in words what they show."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from hub.sim.arena import load_arena
from rune_study.data.overlay import TrialOverlay, simplified
from rune_study.report.comparison import Conditions
from rune_study.report.making import maps_of
from rune_study.report.maps import ConditionMap, colours_of, condition_map, longest_stay

SVG = "{http://www.w3.org/2000/svg}"
WALLS = load_arena("yellow").footprints


def overlay(participant: int, code: str = "A", points: int = 50) -> TrialOverlay:
    """A drive at random in the middle of an arena."""
    random = np.random.default_rng(participant)
    path = 3.0 + np.cumsum(random.normal(0.0, 0.05, (points, 2)), axis=0)
    return TrialOverlay(
        participant=participant,
        trial=1,
        code=code,
        arena="yellow",
        paths=(simplified(path, 0.04),),
        driven=12.0,
        bumps=path[:2],
        victims=np.array([[1.0, 1.0], [2.0, 4.0]]),
        found=np.array([True, participant == 1]),
        false=path[-1:],
        stays={(6, 6): 10.0 * participant, (7, 6): 1.0},
    )


def drawn(*overlays: TrialOverlay, known: bool = True) -> ConditionMap:
    return condition_map(
        "A <map>",
        overlays,
        WALLS if known else None,
        colours_of(each.participant for each in overlays),
        number=3,
        most=longest_stay([overlays]),
    )


def test_a_map_shows_walls_paths_bumps_victims_and_time() -> None:
    found = drawn(overlay(1), overlay(2))
    picture = ElementTree.fromstring(found.svg)
    classes = [each.get("class") for each in picture.iter(f"{SVG}path")]
    assert classes.count("wall") == 1
    assert classes.count("way") == 2 * 3
    assert "stay" in classes
    texts = [each.text for each in picture.iter(f"{SVG}text")]
    assert texts[:2] == ["2/2", "1/2"]
    assert (found.trials, found.bumps, found.found, found.victims, found.false) == (2, 4, 3, 4, 2)


def test_a_reader_that_does_not_see_gets_the_same_in_words() -> None:
    picture = ElementTree.fromstring(drawn(overlay(1), overlay(2)).svg)
    names = (picture.get("aria-labelledby") or "").split()
    words = {each.get("id"): each.text for each in picture if each.get("id")}
    assert [words[name] for name in names] == [
        "A <map>",
        "2 trials, 24 m driven, 4 bumps, 2 marks without a victim. Victims were found in 2 of 2, "
        "1 of 2 trials.",
    ]


def test_paths_are_where_the_plan_says() -> None:
    """The least corner of the arena is at the lower left, half a metre inside of the edge."""
    one = overlay(1)
    corner = np.array([WALLS.low[:, 0].min(), WALLS.low[:, 1].min()])
    picture = ElementTree.fromstring(condition_map_at(one, corner))
    _, _, _, height = map(int, (picture.get("viewBox") or "").split())
    way = next(each for each in picture.iter(f"{SVG}path") if each.get("class") == "way")
    x, y = map(int, re.findall(r"-?\d+", way.get("d") or "")[:2])
    assert x == pytest.approx(50, abs=1)
    assert height - y == pytest.approx(50, abs=1)


def condition_map_at(one: TrialOverlay, place: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    moved = TrialOverlay(
        **{name: getattr(one, name) for name in one.__slots__ if name != "paths"},
        paths=(np.array([place, place + 1.0]),),
    )
    return drawn(moved).svg


def test_an_unknown_arena_is_as_large_as_what_was_driven() -> None:
    found = drawn(overlay(1), known=False)
    assert "The walls are not known." in found.words
    _, _, width, _ = map(int, (ElementTree.fromstring(found.svg).get("viewBox") or "").split())
    assert width < 1000


def test_sixteen_people_fit_in_few_bytes() -> None:
    people = [overlay(person, points=12_000) for person in range(1, 17)]
    assert len(drawn(*people).svg) < 1_000_000


def test_colours_of_neighbours_differ_and_do_not_depend_on_order() -> None:
    colours = colours_of([3, 1, 2, 2])
    assert len(set(colours.values())) == 3
    assert colours == colours_of([1, 2, 3])


def test_each_condition_has_a_map_without_its_levels_in_a_blind_study() -> None:
    levels = ({"layout": "search"}, {"layout": "robobot-2004"}, {"layout": "hri-a"})
    conditions = Conditions(codes=("A", "B", "C"), levels=levels)
    both = [overlay(1, "B"), overlay(1, "A")]
    assert list(maps_of(both, conditions)) == ["A: layout search", "B: layout robobot-2004"]
    assert list(maps_of(both, conditions.blinded())) == ["Condition A", "Condition B"]
    assert maps_of([], conditions) == {}
