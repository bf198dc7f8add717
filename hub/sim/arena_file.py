"""Reads an arena file and checks every key; all mistakes are gathered, none stops the reading.

`hub.sim.arena_specs` declares the keys.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.errors import ArenaError
from hub.nearest import did_you_mean
from hub.sim.arena_specs import (
    MAX_DOORWAYS,
    AirSpec,
    ArenaSpec,
    BerthSpec,
    BoxSpec,
    CylinderSpec,
    DoorwaySpec,
    HallSpec,
    LandmarkSpec,
    RingSpec,
    ScoringSpec,
    StartSpec,
    VictimSpec,
    WallSpec,
    WaterSpec,
)
from hub.sim.ground.map_builder import MAX_CELLS, map_size
from hub.sim.ground.specs import GROUND_TABLES, GroundSpec, TerrainSpec
from hub.values import dataclass

MAX_OBJECTS = 1000
_SHORTEST_WALL = 0.01
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class _Table:
    """A kind of table: its class, its field of `ArenaSpec`, its number there.

    Of an optional one that is not there, the field is None.
    """

    spec: Callable[..., Any]
    field: str
    repeated: bool = True
    optional: bool = False


_TABLES: Mapping[str, _Table] = {
    "start": _Table(StartSpec, "start", repeated=False),
    "hall": _Table(HallSpec, "hall", repeated=False),
    "wall": _Table(WallSpec, "walls"),
    "box": _Table(BoxSpec, "boxes"),
    "cylinder": _Table(CylinderSpec, "cylinders"),
    "victim": _Table(VictimSpec, "victims"),
    "landmark": _Table(LandmarkSpec, "landmarks"),
    "ring": _Table(RingSpec, "rings"),
    "berth": _Table(BerthSpec, "berths"),
    "water": _Table(WaterSpec, "water", repeated=False, optional=True),
    "air": _Table(AirSpec, "air", repeated=False, optional=True),
    "scoring": _Table(ScoringSpec, "scoring", repeated=False),
}
_GROUND: Mapping[str, _Table] = {
    "terrain": _Table(TerrainSpec, "terrain", repeated=False),
    **{name: _Table(kind, field) for name, (kind, field) in GROUND_TABLES.items()},
}
"""The same, with their fields of `GroundSpec`."""
_DOORWAY = _Table(DoorwaySpec, "doorways")


def read_arena_file(path: Path) -> ArenaSpec:
    """Read and check one file.

    Raises:
        ArenaError: It cannot be read, is not TOML, or has mistakes, which are all listed.
    """
    data, problems = toml.load(path, ArenaError)
    spec, problems = check_arena(data, problems)
    if spec is None:
        raise ArenaError(str(path), problems)
    return spec


def check_arena(
    data: Mapping[str, Any], problems: toml.Problems | None = None
) -> tuple[ArenaSpec | None, toml.Problems]:
    """Turn the file's content into a spec; None and all problems if it has mistakes.

    Args:
        data: The content.
        problems: Gets the mistakes, and knows the lines of the file.
    """
    problems = toml.Problems() if problems is None else problems
    top = toml.keys_of(ArenaSpec)
    known = [*top, *_TABLES, *_GROUND]
    for name in data:
        if name not in known:
            text = f"unknown table or key {toml.shorten(name)}{did_you_mean(name, known)}"
            problems.add(toml.TOP, text, name)
    values = {name: value for name, value in data.items() if name in top}
    fields = toml.read_table(top, values, toml.TOP, problems)
    objects = sum(len(value) for value in data.values() if isinstance(value, list))
    if objects > MAX_OBJECTS:
        problems.append(f"{objects} objects are more than the {MAX_OBJECTS} allowed")
        return None, problems
    fields |= _read_tables(_TABLES, data, problems)
    _check_names(fields, problems)
    shape = _read_tables(_GROUND, data, problems)
    if problems:
        return None, problems
    ground = GroundSpec(**shape)
    rows, columns = map_size(ground)
    if rows * columns > MAX_CELLS:
        text = f"terrain: {rows} by {columns} cells are more than the {MAX_CELLS} allowed"
        problems.add("terrain", f"{text}; make key 'cell' larger", "cell")
        return None, problems
    return ArenaSpec(**fields, ground=ground), problems


def _read_tables(
    tables: Mapping[str, _Table], data: Mapping[str, Any], problems: toml.Problems
) -> dict[str, Any]:
    """The specs of all these tables by field name."""
    return {
        table.field: _read_repeated(name, table, data.get(name, []), problems)
        if table.repeated
        else _read_single(name, table, data, problems)
        for name, table in tables.items()
    }


def _read_single(name: str, table: _Table, data: Mapping[str, Any], problems: toml.Problems) -> Any:  # noqa: ANN401 - the table's spec
    if name not in data and table.optional:
        return None
    keys = toml.keys_of(table.spec).values()
    if name not in data and any(key.default is toml.REQUIRED for key in keys):
        problems.append(f"table [{name}] is missing")
        return None
    return _read_spec(table, data.get(name, {}), name, problems)


def _read_repeated(
    place: str, table: _Table, value: object, problems: toml.Problems
) -> tuple[Any, ...]:
    """One spec for each table without mistakes."""
    if not isinstance(value, list):
        problems.add(toml.TOP, f"{place} has to be a list of tables: [[{place}]]", place)
        return ()
    specs = (
        _read_spec(table, item, f"{place} {index}", problems)
        for index, item in enumerate(value, start=1)
    )
    return tuple(spec for spec in specs if spec is not None)


def _read_spec(table: _Table, values: object, place: str, problems: toml.Problems) -> Any:  # noqa: ANN401 - the table's spec
    before = len(problems)
    fields = toml.read_table(toml.keys_of(table.spec), values, place, problems)
    if table.spec is WallSpec:
        fields["doorways"] = _read_doorways(fields["doorways"], place, problems)
    if len(problems) > before:
        return None
    spec = table.spec(**fields)
    if isinstance(spec, WallSpec):
        for problem in _wall_problems(spec):
            problems.add(place, f"{place}: {problem}")
    return spec


def _read_doorways(value: object, place: str, problems: toml.Problems) -> tuple[Any, ...]:
    if value == ():
        return ()
    if not isinstance(value, list):
        text = f"{place}, key 'doorways': {toml.shorten(value)} is not a list of tables"
        problems.add(place, text, "doorways")
        return ()
    if len(value) > MAX_DOORWAYS:
        problems.add(place, f"{place}, key 'doorways': more than {MAX_DOORWAYS}", "doorways")
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
    """Names identify victims, landmarks and berths, so each occurs once."""
    for kind, key in (("victim", "name"), ("landmark", "name"), ("berth", "robot")):
        seen: set[str] = set()
        for number, spec in enumerate(fields[_TABLES[kind].field], start=1):
            name = getattr(spec, key)
            if name in seen:
                text = f"{kind} {toml.shorten(name)}: two have this name"
                problems.add(f"{kind} {number}", text, key)
            seen.add(name)
