"""Reads an arena file and checks every key; all mistakes are gathered, none stops the reading.

`docs/writing-an-arena.md` is the author's side of this file; a test compares the two.
"""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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
MAX_FILE_BYTES = 1_000_000
FARTHEST = 50.0
"""Nothing lies farther from the origin in x or y than this [m]."""


class _RefusedError(ValueError):
    """A value that is not what its key wants; the text says why."""


_Reader = Callable[[object], Any]
_REQUIRED: Any = object()


def _number(low: float, high: float) -> _Reader:
    def read(value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            text = f"{value!r} is not a number"
            raise _RefusedError(text)
        # An integer of any length is valid TOML, so it is compared before it is converted.
        if not low <= value <= high:
            text = f"{_short(value)} is not between {low:g} and {high:g}"
            raise _RefusedError(text)
        return float(value)

    return read


def _numbers(count: int, low: float, high: float) -> _Reader:
    one = _number(low, high)

    def read(value: object) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            text = f"{_short(value)} is not a list of {count} numbers"
            raise _RefusedError(text)
        return tuple(one(item) for item in value)

    return read


def _text(longest: int) -> _Reader:
    def read(value: object) -> str:
        if not isinstance(value, str) or not 1 <= len(value) <= longest:
            text = f"{_short(value)} is not a text of 1 to {longest} characters"
            raise _RefusedError(text)
        return value

    return read


def _choice(names: Iterable[str] | Mapping[str, Any]) -> _Reader:
    known = dict(names) if isinstance(names, Mapping) else {name: name for name in names}

    def read(value: object) -> Any:
        if isinstance(value, str) and value in known:
            return known[value]
        text = f"{_short(value)} is none of {', '.join(known)}{_nearest(value, known)}"
        raise _RefusedError(text)

    return read


def _colour(value: object) -> Colour:
    if isinstance(value, str) and re.fullmatch("#[0-9a-fA-F]{6}", value):
        red, green, blue = bytes.fromhex(value[1:])
        return red, green, blue
    if isinstance(value, str) and value in COLOURS:
        return COLOURS[value]
    hint = _nearest(value, COLOURS)
    text = f"{_short(value)} is neither '#rrggbb' nor one of {', '.join(COLOURS)}{hint}"
    raise _RefusedError(text)


def _short(value: object) -> str:
    try:
        shown = repr(value)
    except ValueError:  # Python refuses to print integers of thousands of digits.
        return "a number of very many digits"
    return shown if len(shown) <= 40 else shown[:37] + "..."


def _nearest(value: object, known: Iterable[str]) -> str:
    if not isinstance(value, str):
        return ""
    near = difflib.get_close_matches(value[:64], list(known), n=1, cutoff=0.5)
    return f"; did you mean {near[0]!r}?" if near else ""


@dataclass(frozen=True, slots=True)
class _Key:
    read: _Reader
    default: Any = _REQUIRED
    field: str = ""


@dataclass(frozen=True, slots=True)
class _Table:
    spec: Callable[..., Any]
    keys: Mapping[str, _Key]
    field: str = ""
    repeated: bool = True


_AT = _Key(_numbers(2, -FARTHEST, FARTHEST))
_NAME = _Key(_text(64))
_FACING = _Key(_choice(FACINGS))
_HEIGHT = _number(0.02, 5.0)
_BASE = _Key(_number(0.0, 5.0), 0.0)
_DOORWAY = _Table(
    DoorwaySpec,
    {
        "at": _Key(_number(0.0, 2 * FARTHEST)),
        "width": _Key(_number(0.1, 20.0), 0.9),
        "height": _Key(_number(0.1, 5.0), None),
    },
)
_TOP_KEYS = {"name": _NAME, "description": _Key(_text(500), "")}


def _surface(texture: str, colour: str) -> dict[str, _Key]:
    return {
        "colour": _Key(_colour, COLOURS[colour]),
        "texture": _Key(_choice(SURFACE_TEXTURES), texture),
    }


_TABLES: Mapping[str, _Table] = {
    "start": _Table(
        StartSpec,
        {"at": _AT, "heading_deg": _Key(_number(-360.0, 360.0), 0.0)},
        "start",
        repeated=False,
    ),
    "hall": _Table(
        HallSpec,
        {
            "ceiling": _Key(_number(1.0, 20.0), 3.0),
            "floor_colour": _Key(_colour, COLOURS["grey"]),
            "floor_texture": _Key(_choice(SURFACE_TEXTURES), "checker"),
        },
        "hall",
        repeated=False,
    ),
    "wall": _Table(
        WallSpec,
        {
            "from": _Key(_AT.read, field="begin"),
            "to": _Key(_AT.read, field="end"),
            "height": _Key(_HEIGHT, 1.2),
            "thickness": _Key(_number(0.02, 2.0), 0.1),
            **_surface("panel", "sand"),
            "doorways": _Key(list, ()),
        },
        "walls",
    ),
    "box": _Table(
        BoxSpec,
        {
            "at": _AT,
            "size": _Key(_numbers(3, 0.01, 20.0)),
            "base": _BASE,
            **_surface("plain", "brown"),
        },
        "boxes",
    ),
    "cylinder": _Table(
        CylinderSpec,
        {
            "at": _AT,
            "radius": _Key(_number(0.01, 5.0)),
            "height": _Key(_HEIGHT),
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
            "pose": _Key(_choice(POSES), "sitting"),
            "colour": _Key(_colour, COLOURS["blue"]),
        },
        "victims",
    ),
    "landmark": _Table(
        LandmarkSpec,
        {
            "name": _NAME,
            "at": _AT,
            "facing": _FACING,
            "height": _Key(_number(0.05, 5.0), 0.6),
            "size": _Key(_number(0.05, 3.0), 0.4),
            "colour": _Key(_colour),
        },
        "landmarks",
    ),
    "ring": _Table(
        RingSpec,
        {
            "at": _AT,
            "facing": _FACING,
            "height": _Key(_number(0.05, 5.0), 0.6),
            "gap_mm": _Key(_number(1.0, 200.0)),
            "gap": _Key(_choice(GAPS)),
        },
        "rings",
    ),
}


def known_keys() -> dict[str, tuple[str, ...]]:
    """Every table of an arena file with its keys; the keys at the top stand under ''."""
    tables = {name: tuple(table.keys) for name, table in _TABLES.items()}
    return {"": tuple(_TOP_KEYS), "doorways": tuple(_DOORWAY.keys), **tables}


def read_arena_file(path: Path) -> ArenaSpec:
    """Read and check one file.

    Raises:
        ArenaError: It cannot be read, is not TOML, or has mistakes, which are all listed.
    """
    try:
        with path.open("rb") as file:
            raw = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise ArenaError(str(path), [f"cannot be read: {error.strerror}"]) from error
    if len(raw) > MAX_FILE_BYTES:
        raise ArenaError(str(path), [f"is larger than {MAX_FILE_BYTES} bytes"])
    try:
        data = tomllib.loads(raw.decode())
    except UnicodeDecodeError as error:
        raise ArenaError(str(path), [f"is not UTF-8 text at byte {error.start}"]) from error
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise ArenaError(str(path), [f"is not TOML: {error}"]) from error
    spec, problems = check_arena(data)
    if spec is None:
        raise ArenaError(str(path), problems)
    return spec


def check_arena(data: Mapping[str, Any]) -> tuple[ArenaSpec | None, list[str]]:
    """Turn what the file says into a spec; None and all problems where it has mistakes."""
    problems: list[str] = []
    known = [*_TOP_KEYS, *_TABLES]
    top = {name: value for name, value in data.items() if name in _TOP_KEYS}
    for name in data:
        if name not in known:
            problems.append(f"unknown table or key {_short(name)}{_nearest(name, known)}")
    fields = _read_keys(_TOP_KEYS, top, "top of the file", problems)
    objects = sum(len(value) for value in data.values() if isinstance(value, list))
    if objects > MAX_OBJECTS:
        problems.append(f"{objects} objects are more than the {MAX_OBJECTS} allowed")
        return None, problems
    for name, table in _TABLES.items():
        fields[table.field] = _read_table(name, table, data.get(name), problems)
    _check_names(fields, problems)
    return (None if problems else ArenaSpec(**fields)), problems


def _read_table(name: str, table: _Table, value: object, problems: list[str]) -> Any:
    """One spec for a single table, a tuple of specs for a repeated one."""
    if not table.repeated:
        if value is None and name == "start":
            problems.append("table [start] is missing")
            return None
        if value is not None and not isinstance(value, dict):
            problems.append(f"{name} has to be one table: [{name}]")
            return None
        return _read_spec(table, value or {}, name, problems)
    if value is None:
        return ()
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        problems.append(f"{name} has to be a list of tables: [[{name}]]")
        return ()
    specs = (
        _read_spec(table, item, f"{name} {index}", problems)
        for index, item in enumerate(value, start=1)
    )
    return tuple(spec for spec in specs if spec is not None)


def _read_spec(table: _Table, values: dict[str, Any], place: str, problems: list[str]) -> Any:
    before = len(problems)
    for key in values:
        if key not in table.keys:
            problems.append(f"{place}: unknown key {_short(key)}{_nearest(key, table.keys)}")
    fields = _read_keys(table.keys, values, place, problems)
    if table.spec is WallSpec:
        fields["doorways"] = _read_doorways(values.get("doorways", []), place, problems)
    if len(problems) > before:
        return None
    spec = table.spec(**fields)
    if isinstance(spec, WallSpec):
        problems.extend(f"{place}: {problem}" for problem in _wall_problems(spec))
    return spec


def _read_keys(
    keys: Mapping[str, _Key], values: Mapping[str, Any], place: str, problems: list[str]
) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for name, key in keys.items():
        field = key.field or name
        if name not in values:
            fields[field] = key.default
            if key.default is _REQUIRED:
                problems.append(f"{place}: key '{name}' is missing")
            continue
        try:
            fields[field] = key.read(values[name])
        except _RefusedError as refused:
            problems.append(f"{place}, key '{name}': {refused}")
        except TypeError:
            problems.append(f"{place}, key '{name}': {_short(values[name])} is not a list")
    return fields


def _read_doorways(value: object, place: str, problems: list[str]) -> tuple[DoorwaySpec, ...]:
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        problems.append(f"{place}, key 'doorways': it has to be a list of tables")
        return ()
    if len(value) > MAX_DOORWAYS:
        problems.append(f"{place}, key 'doorways': more than {MAX_DOORWAYS}")
        return ()
    specs = (
        _read_spec(_DOORWAY, item, f"{place}, doorway {index}", problems)
        for index, item in enumerate(value, start=1)
    )
    return tuple(spec for spec in specs if spec is not None)


def _wall_problems(wall: WallSpec) -> Iterable[str]:
    along_x, along_y = (abs(e - b) for b, e in zip(wall.begin, wall.end, strict=True))
    if min(along_x, along_y) > 1e-9:
        yield "it is slanted; 'from' and 'to' must share x or y"
        return
    length = math.hypot(along_x, along_y)
    if length < 0.01:
        yield "it has no length; 'from' and 'to' are the same place"
    reached = 0.0
    for index, door in sorted(enumerate(wall.doorways, start=1), key=lambda item: item[1].at):
        left, right = door.at - door.width / 2, door.at + door.width / 2
        if left < -1e-9 or right > length + 1e-9:
            yield f"doorway {index} reaches beyond the wall, which is {length:g} m long"
        elif left < reached - 1e-9:
            yield f"doorway {index} overlaps another"
        reached = max(reached, right)


def _check_names(fields: Mapping[str, Any], problems: list[str]) -> None:
    """A name says which victim or landmark is meant, so it stands once."""
    for kind in ("victim", "landmark"):
        seen: set[str] = set()
        for spec in fields[_TABLES[kind].field]:
            if spec.name in seen:
                problems.append(f"{kind} {_short(spec.name)}: two have this name")
            seen.add(spec.name)
