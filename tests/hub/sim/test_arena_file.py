"""What an arena file may say, and what it is told when it is wrong."""

from __future__ import annotations

import math
import re
import tempfile
import tomllib
from pathlib import Path

import numpy as np
import pytest

from hub.errors import ArenaError
from hub.gcm.body import USUAL_RADIUS
from hub.sim.arena import SHIPPED, load_arena, shipped_arenas
from hub.sim.arena_file import MAX_OBJECTS, check_arena, read_arena_file
from hub.sim.arena_specs import GAPS
from hub.sim.camera.textures import TEXTURES
from hub.sim.spec_values import COLOURS, SURFACE_TEXTURES
from tests.support.cases import for_each
from tests.support.footprints import distances

DOCUMENT = Path(__file__).parents[3] / "docs" / "writing-an-arena.md"
GOOD = """
name = "test"
[start]
at = [0.0, 0.0]
[[wall]]
from = [-3.0, 2.0]
to = [3.0, 2.0]
doorways = [{ at = 1.0 }, { at = 4.0, width = 1.0, height = 0.9 }]
[[box]]
at = [2.0, 0.0]
size = [0.5, 0.5, 0.5]
[[cylinder]]
at = [-2.0, 0.0]
radius = 0.2
height = 0.5
[[victim]]
name = "one"
at = [0.0, -2.0]
facing = "east"
[[landmark]]
name = "red"
at = [0.0, 1.95]
facing = "south"
colour = "red"
[[ring]]
at = [1.5, 1.95]
facing = "south"
gap_mm = 5
gap = "up"
[water]
surface = 1.5
area = [[-1.0, -1.0], [1.0, 1.0]]
[air]
wind = [0.5, 0.0]
[[berth]]
robot = "blimp"
at = [0.0, 0.5]
height = 1.0
heading_deg = 90
"""


def problems_of(text: str) -> list[str]:
    return check_arena(tomllib.loads(text))[1]


def test_a_good_file_has_no_problems() -> None:
    assert problems_of(GOOD) == []


@for_each(
    ("old", "new", "problem"),
    [
        ('name = "test"', "", "top of the file: key 'name' is missing"),
        ('name = "test"', "name = 5", "top of the file, key 'name': 5 is not a text"),
        ("[start]\nat = [0.0, 0.0]", "", "table [start] is missing"),
        ("[start]\nat = [0.0, 0.0]", "[start]", "start: key 'at' is missing"),
        ("[start]", "[stard]", "unknown table or key 'stard'; did you mean 'start'?"),
        ("[[wall]]", "[[wal]]", "unknown table or key 'wal'; did you mean 'wall'?"),
        ("[[box]]", "[box]", "box has to be a list of tables: [[box]]"),
        ("at = [0.0, 0.0]", "at = [0.0]", "start, key 'at': [0.0] is not a list of 2 numbers"),
        ("at = [0.0, 0.0]", "at = [0.0, inf]", "start, key 'at': inf is not between -50 and 50"),
        ("at = [0.0, 0.0]", "at = [nan, 0.0]", "start, key 'at': nan is not between -50 and 50"),
        ("radius = 0.2", "radius = true", "cylinder 1, key 'radius': True is not a number"),
        ("radius = 0.2", "radius = 6", "cylinder 1, key 'radius': 6 is not between 0.01 and 5"),
        ("radius = 0.2", "", "cylinder 1: key 'radius' is missing"),
        ("radius", "radious", "cylinder 1: unknown key 'radious'; did you mean 'radius'?"),
        ("[0.5, 0.5, 0.5]", "[0.5, 0, 0.5]", "box 1, key 'size': 0 is not between 0.01 and 20"),
        ("[0.5, 0.5, 0.5]", '"big"', "box 1, key 'size': 'big' is not a list of 3 numbers"),
        ('"red"\n[[ring', '"rde"\n[[ring', "landmark 1, key 'colour': 'rde' is neither"),
        ('"red"\n[[ring', '"#12345"\n[[ring', "landmark 1, key 'colour': '#12345' is neither"),
        ('"east"', '"eats"', "victim 1, key 'facing': 'eats' is none of"),
        ('"up"', '"upp"', "did you mean 'up'?"),
        ("to = [3.0, 2.0]", "to = [3.0, 2.5]", "wall 1: it is slanted"),
        ("to = [3.0, 2.0]", "to = [-3.0, 2.0]", "wall 1: it is shorter than 0.01 m"),
        ("at = 4.0", "at = 5.8", "wall 1: doorway 2 reaches beyond the wall, which is 6 m long"),
        ("at = 4.0", "at = 1.5", "wall 1: doorway 2 overlaps another"),
        ("{ at = 1.0 }", "{ }", "wall 1, doorway 1: key 'at' is missing"),
        ("{ at = 1.0 }", "7", "wall 1, doorway 1: 7 is not a table"),
        ("[{ at = 1.0 }", "{} # [{ at = 1.0 }", "wall 1, key 'doorways': {} is not a list"),
        ("{ at = 1.0 }", ", ".join(["{ at = 0.1 }"] * 17), "wall 1, key 'doorways': more than 16"),
        (
            "[[landmark]]",
            '[[victim]]\nname="one"\nat=[3,3]\nfacing="east"\n[[landmark]]',
            "victim 'one': two have this name",
        ),
        ("[[berth]]", '[[berth]]\nrobot="blimp"\nat=[3,3]\n[[berth]]', "berth 'blimp': two have"),
        ("[[berth]]", "[berth]", "berth has to be a list of tables: [[berth]]"),
        ("surface = 1.5", "", "water: key 'surface' is missing"),
        ("surface = 1.5", "surface = 0", "water, key 'surface': 0 is not between 0.1 and 20"),
        ("surface = 1.5", 'surface = 1.5\ntype = "1D"', "water, key 'type': '1D' is none of I, II"),
        (
            "[1.0, 1.0]]",
            "[1.0, 1.0], []]",
            "is not a list of two corners",
        ),
        ("[1.0, 1.0]]", "[1.0, -3.0]]", "is not the south-west corner and the north-east one"),
        ("[1.0, 1.0]]", "[1.0]]", "water, key 'area': [1.0] is not a list of 2 numbers"),
        ("wind = [0.5, 0.0]", "wind = 3", "air, key 'wind': 3 is not a list of 2 numbers"),
    ],
)
def test_each_mistake_is_told_with_its_place(old: str, new: str, problem: str) -> None:
    assert old in GOOD
    assert problem in "\n".join(problems_of(GOOD.replace(old, new)))


def test_all_mistakes_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    wrong = GOOD.replace("radius = 0.2", "radius = -1").replace('"east"', '"up"')
    path.write_text(wrong.replace("to = [3.0, 2.0]", "too = [3.0, 2.0]"))
    with pytest.raises(ArenaError) as caught:
        load_arena(str(path))
    found = caught.value.problems
    assert len(found) == 4
    places = {
        "wall 1: unknown key 'too'": "too = ",
        "wall 1: key 'to'": "[[wall]]",
        "cylinder 1": "radius = ",
        "victim 1": "facing = ",
    }
    lines = path.read_text().splitlines()
    for place, line in places.items():
        (problem,) = (each for each in found if place in each)
        number = re.match(r"line (\d+): ", problem)
        assert number is not None
        assert lines[int(number[1]) - 1].startswith(line)
    assert str(caught.value).count(str(path)) == 4


def test_water_air_and_berths_are_read_and_are_absent_where_the_file_has_none(
    tmp_path: Path,
) -> None:
    path = tmp_path / "arena.toml"
    path.write_text(GOOD)
    arena = load_arena(str(path))
    assert arena.water is not None
    assert (arena.water.surface, arena.water.type) == (1.5, "1C")
    assert arena.water.area == ((-1.0, -1.0), (1.0, 1.0))
    assert arena.air is not None
    assert (arena.air.draft, arena.air.wind) == (0.04, (0.5, 0.0))
    berth = arena.berth("blimp")
    assert berth is not None
    assert (berth.at, berth.height, berth.heading) == ((0.0, 0.5), 1.0, math.pi / 2)
    assert arena.berth("rov") is None
    dry = load_arena("yellow")
    assert (dry.water, dry.air, dry.berths) == (None, None, ())


@for_each(
    ("old", "new", "problem"),
    [
        ("height = 1.0\nheading", "height = 3.5\nheading", "berth 1: it is not below the ceiling"),
        ("[0.0, 0.5]", "[0.0, 2.0]", "berth 1: it is inside a solid"),
        ("at = [0.0, 0.5]\nheight = 1.0", "at = [-2.1, 0.1]", "berth 1: it is inside a solid"),
    ],
)
def test_a_berth_in_a_solid_or_above_the_ceiling_is_refused(
    old: str, new: str, problem: str
) -> None:
    assert old in GOOD
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arena.toml"
        path.write_text(GOOD.replace(old, new))
        with pytest.raises(ArenaError, match=problem):
            load_arena(str(path))


def test_too_many_objects_are_refused() -> None:
    crate = "[[box]]\nat = [3.0, 3.0]\nsize = [0.1, 0.1, 0.1]\n"
    assert any("allowed" in problem for problem in problems_of(GOOD + crate * MAX_OBJECTS))


def test_a_start_inside_something_is_refused_with_the_name_of_the_place(tmp_path: Path) -> None:
    path = tmp_path / "blocked.toml"
    path.write_text(GOOD.replace("[2.0, 0.0]", "[0.3, 0.0]"))
    with pytest.raises(ArenaError, match="start: the robot would touch box 1"):
        load_arena(str(path))


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"name = ", "is not TOML"),
        (b"\xff\xfe", "is not UTF-8"),
        (b"#" * 1_000_001, "larger than"),
    ],
)
def test_a_file_that_is_no_toml_is_refused(tmp_path: Path, content: bytes, complaint: str) -> None:
    path = tmp_path / "broken.toml"
    path.write_bytes(content)
    with pytest.raises(ArenaError, match=complaint):
        load_arena(str(path))


@for_each("name", ["no-such/arena.toml", "nothing.toml", "\0.toml", "a" * 5000])
def test_a_file_that_is_not_there_is_refused(name: str) -> None:
    with pytest.raises(ArenaError):
        load_arena(name)


def test_a_misspelt_shipped_name_is_told_the_nearest() -> None:
    with pytest.raises(ArenaError, match="did you mean 'yellow'"):
        load_arena("yelow")


def test_every_shipped_arena_loads_and_has_room_for_the_robot() -> None:
    assert set(shipped_arenas()) == {"empty", "hall", "orange", "pool", "red", "yellow"}
    for name in shipped_arenas():
        arena = load_arena(name)
        assert read_arena_file(SHIPPED / f"{name}.toml").landmarks
        assert arena.footprints.distances(arena.start.x, arena.start.y).min() > 2 * USUAL_RADIUS


@pytest.mark.parametrize(("name", "size"), [("yellow", (10.0, 10.0)), ("pool", (6.0, 8.0))])
def test_every_room_of_a_shipped_arena_can_be_reached(name: str, size: tuple[float, float]) -> None:
    """Flood the places where the robot fits, in steps of 5 cm, from its start."""
    arena = load_arena(name)
    step = 0.05
    x, y = np.indices((round(size[0] / step), round(size[1] / step))) * step
    free = distances(arena.footprints, x, y) > USUAL_RADIUS + 0.05
    reached = np.zeros_like(free)
    reached[round(arena.start.x / step), round(arena.start.y / step)] = True
    while True:
        grown = reached.copy()
        grown[1:] |= reached[:-1]
        grown[:-1] |= reached[1:]
        grown[:, 1:] |= reached[:, :-1]
        grown[:, :-1] |= reached[:, 1:]
        grown &= free
        if (grown == reached).all():
            break
        reached = grown
    for victim in read_arena_file(SHIPPED / f"{name}.toml").victims:
        x, y = victim.at
        near = reached[
            round((x - 1.2) / step) : round((x + 1.2) / step),
            round(max(0.0, y - 1.2) / step) : round((y + 1.2) / step),
        ]
        assert near.any(), victim.name
    assert reached.sum() > 0.95 * free.sum()


def test_signs_of_shipped_arenas_hang_on_something() -> None:
    for name in shipped_arenas():
        arena = load_arena(name)
        for box in arena.boxes:
            if box.picture is None or box.picture.texture == "face":
                continue
            side = box.picture_side
            assert side is not None
            middle = [(low + high) / 2 for low, high in zip(box.low, box.high, strict=True)]
            back = box.low if side.sign > 0 else box.high
            middle[side.axis] = back[side.axis] - side.sign * 0.005
            assert any(
                all(o.low[axis] <= middle[axis] <= o.high[axis] for axis in range(3))
                for o in arena.boxes
            ), f"{name}: {box}"


def test_a_doorway_is_open_and_its_lintel_closes_the_wall_above() -> None:
    spec, _ = check_arena(tomllib.loads(GOOD))
    assert spec is not None
    from hub.sim.building import build

    walls = [box for box in build(spec)[0] if box.low[1] == pytest.approx(1.95)]
    low = sorted((box.low[0], box.high[0]) for box in walls if box.low[2] == 0.0)
    assert np.allclose(low, [(-3.0, -2.45), (-1.55, 0.5), (1.5, 3.0)])
    (lintel,) = [box for box in walls if box.low[2] > 0.0]
    assert np.allclose((lintel.low[0], lintel.high[0], lintel.low[2]), (0.5, 1.5, 0.9))


def test_the_document_names_every_colour_texture_and_gap() -> None:
    text = DOCUMENT.read_text()
    for name in (*COLOURS, *SURFACE_TEXTURES, *GAPS):
        assert f"`{name}`" in text


def test_the_example_of_the_document_is_an_arena(tmp_path: Path) -> None:
    example = re.search(r"```toml\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    assert example is not None
    path = tmp_path / "example.toml"
    path.write_text(example[1])
    load_arena(str(path))
    spec = read_arena_file(path)
    assert len(spec.victims) == len(spec.landmarks) == len(spec.rings) == 1


def test_every_name_an_author_may_use_has_a_texture() -> None:
    assert {*SURFACE_TEXTURES, *(f"ring {gap}" for gap in GAPS)} <= set(TEXTURES)
