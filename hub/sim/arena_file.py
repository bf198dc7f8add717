"""Reads an arena file and checks every key; all mistakes are gathered, none stops the reading.

`docs/writing-an-arena.md` is the author's side of this file; a test compares the two.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.errors import ArenaError
from hub.sim.arena_specs import (
    COLOURS,
    FACINGS,
    GAPS,
    POSES,
    SURFACE_TEXTURES,
    ArenaSpec,
    BoxSpec,
    CylinderSpec,
    DoorwaySpec,
    HallSpec,
    LandmarkSpec,
    RingSpec,
    StartSpec,
    VictimSpec,
    WallSpec,
)
from hub.sim.geometry import Colour

MAX_OBJECTS = 1000
MAX_DOORWAYS = 16
FARTHEST = 50.0
"""Nothing lies farther from the origin in x or y than this [m]."""
_SHORTEST_WALL = 0.01
_ROUNDING = 1e-9


def _colour(value: object) -> Colour:
    if isinstance(value, str) and re.fullmatch("#[0-9a-fA-F]{6}", value):
        red, green, blue = bytes.fromhex(value[1:])
        return red, green, blue
    if isinstance(value, str) and value in COLOURS:
        return COLOURS[value]
    hint = toml.nearest(value, COLOURS)
    text = f"{toml.shorten(value)} is neither '#rrggbb' nor one of {', '.join(COLOURS)}{hint}"
    raise toml.RefusedError(text)


def _as_written(value: object) -> object:
    """For what is checked later."""
    return value


@dataclass(frozen=True, slots=True)
class _Table:
    """A kind of table: what it becomes, its keys, its field of `ArenaSpec`, and how often it is."""

    spec: Callable[..., Any]
    keys: Mapping[str, toml.Key]
    field: str = ""
    repeated: bool = True


_AT = toml.Key(toml.numbers(2, -FARTHEST, FARTHEST))
_NAME = toml.Key(toml.text(64))
_FACING = toml.Key(toml.choice(FACINGS))
_HEIGHT = toml.number(0.02, 5.0)
_BASE = toml.Key(toml.number(0.0, 5.0), 0.0)
_DOORWAY = _Table(
    DoorwaySpec,
    {
        "at": toml.Key(toml.number(0.0, 2 * FARTHEST)),
        "width": toml.Key(toml.number(0.1, 20.0), 0.9),
        "height": toml.Key(toml.number(0.1, 5.0), None),
    },
)
_TOP = {"name": _NAME, "description": toml.Key(toml.text(500), "")}


def _surface(texture: str, colour: str) -> dict[str, toml.Key]:
    return {
        "colour": toml.Key(_colour, COLOURS[colour]),
        "texture": toml.Key(toml.choice(SURFACE_TEXTURES), texture),
    }


_TABLES: Mapping[str, _Table] = {
    "start": _Table(
        StartSpec,
        {"at": _AT, "heading_deg": toml.Key(toml.number(-360.0, 360.0), 0.0)},
        "start",
        repeated=False,
    ),
    "hall": _Table(
        HallSpec,
        {
            "ceiling": toml.Key(toml.number(1.0, 20.0), 3.0),
            "floor_colour": toml.Key(_colour, COLOURS["grey"]),
            "floor_texture": toml.Key(toml.choice(SURFACE_TEXTURES), "checker"),
            "light": toml.Key(toml.number(0.0, 1.0), 1.0),
        },
        "hall",
        repeated=False,
    ),
    "wall": _Table(
        WallSpec,
        {
            "from": toml.Key(_AT.read, field="begin"),
            "to": toml.Key(_AT.read, field="end"),
            "height": toml.Key(_HEIGHT, 1.2),
            "thickness": toml.Key(toml.number(0.02, 2.0), 0.1),
            **_surface("panel", "sand"),
            "doorways": toml.Key(_as_written, []),
        },
        "walls",
    ),
    "box": _Table(
        BoxSpec,
        {
            "at": _AT,
            "size": toml.Key(toml.numbers(3, 0.01, 20.0)),
            "base": _BASE,
            **_surface("plain", "brown"),
        },
        "boxes",
    ),
    "cylinder": _Table(
        CylinderSpec,
        {
            "at": _AT,
            "radius": toml.Key(toml.number(0.01, 5.0)),
            "height": toml.Key(_HEIGHT),
            "base": _BASE,
            **_surface("plain", "grey"),
        },
        "cylinders",
    ),
    "victim": _Table(
        VictimSpec,
        {
            "name": _NAME,
            "at": _AT,
            "facing": _FACING,
            "pose": toml.Key(toml.choice(POSES), "sitting"),
            "colour": toml.Key(_colour, COLOURS["blue"]),
        },
        "victims",
    ),
    "landmark": _Table(
        LandmarkSpec,
        {
            "name": _NAME,
            "at": _AT,
            "facing": _FACING,
            "height": toml.Key(toml.number(0.05, 5.0), 0.6),
            "size": toml.Key(toml.number(0.05, 3.0), 0.4),
            "colour": toml.Key(_colour),
        },
        "landmarks",
    ),
    "ring": _Table(
        RingSpec,
        {
            "at": _AT,
            "facing": _FACING,
            "height": toml.Key(toml.number(0.05, 5.0), 0.6),
            "gap_mm": toml.Key(toml.number(1.0, 200.0)),
            "gap": toml.Key(toml.choice(GAPS)),
        },
        "rings",
    ),
}


def known_keys() -> dict[str, tuple[str, ...]]:
    """Every table of an arena file with its keys; the keys at the top stand under ''."""
    tables = {name: tuple(table.keys) for name, table in _TABLES.items()}
    return {"": tuple(_TOP), "doorways": tuple(_DOORWAY.keys), **tables}


def read_arena_file(path: Path) -> ArenaSpec:
    """Read and check one file.

    Raises:
        ArenaError: It cannot be read, is not TOML, or has mistakes, which are all listed.
    """
    data, _ = toml.load(path, ArenaError)
    spec, problems = check_arena(data)
    if spec is None:
        raise ArenaError(str(path), problems)
    return spec


def check_arena(data: Mapping[str, Any]) -> tuple[ArenaSpec | None, list[str]]:
    """Turn what the file says into a spec; None and all problems where it has mistakes."""
    problems = toml.Problems()
    known = [*_TOP, *_TABLES]
    problems += [
        f"unknown table or key {toml.shorten(name)}{toml.nearest(name, known)}"
        for name in data
        if name not in known
    ]
    top = {name: value for name, value in data.items() if name in _TOP}
    fields = toml.read_table(_TOP, top, "top of the file", problems)
    objects = sum(len(value) for value in data.values() if isinstance(value, list))
    if objects > MAX_OBJECTS:
        return None, [*problems, f"{objects} objects are more than the {MAX_OBJECTS} allowed"]
    for name, table in _TABLES.items():
        if table.repeated:
            fields[table.field] = _read_repeated(name, table, data.get(name, []), problems)
        else:
            fields[table.field] = _read_single(name, table, data, problems)
    _check_names(fields, problems)
    return (None if problems else ArenaSpec(**fields)), problems


def _read_single(name: str, table: _Table, data: Mapping[str, Any], problems: toml.Problems) -> Any:  # noqa: ANN401 - the table's spec
    if name not in data and any(key.default is toml.REQUIRED for key in table.keys.values()):
        problems.append(f"table [{name}] is missing")
        return None
    return _read_spec(table, data.get(name, {}), name, problems)


def _read_repeated(
    place: str, table: _Table, value: object, problems: toml.Problems
) -> tuple[Any, ...]:
    """One spec for each table without mistakes."""
    if not isinstance(value, list):
        problems.append(f"{place} has to be a list of tables: [[{place}]]")
        return ()
    specs = (
        _read_spec(table, item, f"{place} {index}", problems)
        for index, item in enumerate(value, start=1)
    )
    return tuple(spec for spec in specs if spec is not None)


def _read_spec(table: _Table, values: object, place: str, problems: toml.Problems) -> Any:  # noqa: ANN401 - the table's spec
    before = len(problems)
    fields = toml.read_table(table.keys, values, place, problems)
    if table.spec is WallSpec:
        fields["doorways"] = _read_doorways(fields["doorways"], place, problems)
    if len(problems) > before:
        return None
    spec = table.spec(**fields)
    if isinstance(spec, WallSpec):
        problems.extend(f"{place}: {problem}" for problem in _wall_problems(spec))
    return spec


def _read_doorways(value: object, place: str, problems: toml.Problems) -> tuple[Any, ...]:
    if not isinstance(value, list):
        problems.append(f"{place}, key 'doorways': {toml.shorten(value)} is not a list of tables")
        return ()
    if len(value) > MAX_DOORWAYS:
        problems.append(f"{place}, key 'doorways': more than {MAX_DOORWAYS}")
        return ()
    return _read_repeated(f"{place}, doorway", _DOORWAY, value, problems)


def _wall_problems(wall: WallSpec) -> Iterable[str]:
    along_x, along_y = (abs(e - b) for b, e in zip(wall.begin, wall.end, strict=True))
    if min(along_x, along_y) > 0.0:
        yield "it is slanted; 'from' and 'to' must share x or y"
        return
    length = math.hypot(along_x, along_y)
    if length < _SHORTEST_WALL:
        yield f"it is shorter than {_SHORTEST_WALL:g} m"
        return
    reached = 0.0
    for index, door in sorted(enumerate(wall.doorways, start=1), key=lambda item: item[1].at):
        left, right = door.at - door.width / 2, door.at + door.width / 2
        if left < -_ROUNDING or right > length + _ROUNDING:
            yield f"doorway {index} reaches beyond the wall, which is {length:g} m long"
        elif left < reached - _ROUNDING:
            yield f"doorway {index} overlaps another"
        reached = max(reached, right)


def _check_names(fields: Mapping[str, Any], problems: toml.Problems) -> None:
    """A name says which victim or landmark is meant, so it stands once."""
    for kind in ("victim", "landmark"):
        seen: set[str] = set()
        for spec in fields[_TABLES[kind].field]:
            if spec.name in seen:
                problems.append(f"{kind} {toml.shorten(spec.name)}: two have this name")
            seen.add(spec.name)
