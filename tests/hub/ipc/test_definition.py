"""Definitions: dataclasses against formats, and definitions told to and from central."""

from __future__ import annotations

import dataclasses
import types
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError, MessageFormatError
from hub.gcm.catalog import MESSAGES
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import grammar as formats
from hub.ipc.wire import control
from hub.ipc.wire.definition_listing import from_listing, to_listing
from tests.hub.ipc.shapes import Even, Mode, Nothing, One, Open, Point, define, payload, plain
from tests.support.cases import for_each


@dataclass(frozen=True, slots=True, kw_only=True)
class Path:
    mode: Mode
    start: Point
    count: int
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Waypoint:
    place: Point
    next: Waypoint | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Tour:
    route: Waypoint | None
    home: Point | None
    grid: tuple[Point, ...]
    stops: tuple[Point | None, ...]
    count: int
    walks: tuple[Waypoint, ...]
    modes: tuple[Mode, ...]
    hint: int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Odd:
    items: int
    get: Point


PATH = MessageDefinition(name="Path", format="{{enum:2},{int,int},uint,<{int,int}:3>}", type=Path)
_VALUE = Path(
    mode=Mode.ON, start=Point(x=1, y=2), count=2, points=(Point(x=3, y=4), Point(x=5, y=6))
)


TOUR = MessageDefinition(
    name="Tour",
    format="{*{{int,int},*!},*{int,int},[{int,int}:1,2],[*{int,int}:2],uint,<{{int,int},*!}:5>,"
    "<{enum:2}:5>,*int}",
    type=Tour,
)
ROUTE = MessageDefinition(name="Route", format="{{int,int},*!}", type=Waypoint)
_ROUTE = Waypoint(place=Point(x=1, y=2), next=Waypoint(place=Point(x=3, y=4), next=None))
_TOUR = Tour(
    route=_ROUTE,
    home=Point(x=5, y=6),
    grid=(Point(x=7, y=8), Point(x=9, y=10)),
    stops=(None, Point(x=11, y=12)),
    count=2,
    walks=(_ROUTE, Waypoint(place=Point(x=13, y=14), next=None)),
    modes=(Mode.ON, Mode.OFF),
    hint=3,
)
_NO_TOUR = dataclasses.replace(
    _TOUR, route=None, home=None, stops=(None, None), count=0, walks=(), modes=(), hint=None
)
ODD = MessageDefinition(name="Odd", format="{int,{int,int}}", type=Odd)


@for_each(
    ("definition", "value"),
    [
        (PATH, _VALUE),
        (define(One, "{string}"), One(text="a")),
        (define(Nothing, "{}"), Nothing()),
        (define(Even, "{int}"), Even(number=2)),
        (define(Open, "{int,int}"), Open(x=1, y=2)),
        (ROUTE, _ROUTE),
        (TOUR, _TOUR),
        (TOUR, _NO_TOUR),
        (ODD, Odd(items=1, get=Point(x=2, y=3))),
    ],
)
def test_dataclass_comes_back_as_it_was(definition: MessageDefinition[Any], value: Any) -> None:
    back = definition.decode(payload(definition, value))
    assert type(back) is type(value)
    assert back == value


def test_decoded_value_is_frozen_and_hashable_like_any_other() -> None:
    back = PATH.decode(payload(PATH, _VALUE))
    assert hash(back) == hash(_VALUE)
    assert type(back.mode) is Mode
    with pytest.raises(dataclasses.FrozenInstanceError):
        back.count = 3
    with pytest.raises(dataclasses.FrozenInstanceError):
        back.start.x = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Place(Point):
    z: int


def test_value_with_inherited_fields_is_made_without_its_constructor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The constructor of a frozen class takes longer than all else."""
    definition = MessageDefinition(name="T_Place", format="{int,int,int}", type=Place)
    value = Place(x=1, y=2, z=3)
    payload = b"".join(definition.encode(value))
    decoded = definition.decode(payload)
    assert decoded == value
    assert hash(decoded) == hash(value)
    assert type(decoded) is Place
    with pytest.raises(dataclasses.FrozenInstanceError):
        decoded.x = 4
    monkeypatch.delattr(Place, "__init__")
    assert definition.decode(payload) == value


def test_field_names_are_shown_in_the_nesting_of_the_format() -> None:
    assert PATH.fields == "mode, start{x, y}, count, points[]{x, y}"
    assert TOUR.fields == (
        "route*{place{x, y}, next}, home*{x, y}, grid[]{x, y}, stops[]*{x, y}, count, "
        "walks[]{place{x, y}, next}, modes, hint"
    )


@for_each(
    ("kind", "text", "reason"),
    [
        (Point, "int", "struct"),
        (Point, "{int}", "2 fields"),
        (Point, "{int,{int}}", "needs a dataclass"),
        (Point, "{int,[{int}:2]}", "needs a dataclass"),
        (Point, "{uint,<{int}:1>}", "needs a dataclass"),
        (int, "{int}", "needs a dataclass"),
        (Point, "{int,", "position 5"),
        (Point, "{int,*{int}}", "needs a dataclass"),
        (Waypoint, "{{int,int},*!,int}", "2 fields"),
    ],
)
def test_type_that_does_not_fit_its_format_is_refused(
    kind: type[Any], text: str, reason: str
) -> None:
    with pytest.raises(MessageFormatError, match=reason):
        define(kind, text)


@for_each("name", ["", "a b", "1a", "a\0", "ä", "a.b", "x" * 65])
def test_name_that_could_be_mistaken_on_the_wire_is_refused(name: str) -> None:
    with pytest.raises(MessageFormatError):
        MessageDefinition(name=name, format="{}", type=Nothing)


@for_each(
    "value",
    [
        None,
        One(text="x"),
        dataclasses.replace(_VALUE, mode=1.5),
        dataclasses.replace(_VALUE, mode=None),
        dataclasses.replace(_VALUE, start=None),
        dataclasses.replace(_VALUE, start=(1, 2)),
        dataclasses.replace(_VALUE, points=None),
        dataclasses.replace(_VALUE, points=(1, 2)),
        dataclasses.replace(_VALUE, count=3),
        dataclasses.replace(_VALUE, count="2"),
    ],
)
def test_value_of_another_kind_is_refused(value: Any) -> None:
    with pytest.raises(CodecError):
        PATH.encode(value)


def test_enum_number_without_a_name_is_refused() -> None:
    raw = bytearray(payload(PATH, _VALUE))
    raw[4] = 1
    with pytest.raises(CodecError, match=r"Path.mode: 1 is none of \[0, 2\]"):
        PATH.decode(bytes(raw))


def test_value_that_its_type_refuses_is_a_codec_error() -> None:
    definition = define(Even, "{int}")
    with pytest.raises(CodecError, match="odd"):
        definition.decode(bytes.fromhex("0001000003000000"))


@pytest.mark.parametrize("values", [(), (1,), (1, 2, 3)])
def test_wrong_number_of_members_is_refused(values: tuple[int, ...]) -> None:
    with pytest.raises(CodecError):
        define(Point, "{int,int}").build(values)


@for_each("definition", [*MESSAGES, PATH, TOUR, ROUTE])
def test_listing_tells_enough_to_decode_without_the_dataclass(
    definition: MessageDefinition[Any],
) -> None:
    told = to_listing(definition)
    known = from_listing(told)
    assert known.fingerprint == definition.fingerprint
    assert known.fields == definition.fields
    assert to_listing(known) == told


def test_generated_dataclass_holds_the_values() -> None:
    shown = from_listing(to_listing(PATH)).decode(payload(PATH, _VALUE))
    assert shown.start.y == 2
    assert [point.x for point in shown.points] == [3, 5]
    assert shown.mode == 2


def _listing(fields: str, text: str = "{int,int}", **changes: Any) -> control.Define:
    entry = control.Define(
        name="M",
        format=text,
        fields=fields,
        keep="newest",
        plane="state",
        rate_hz=0.0,
        lifespan_s=0.0,
    )
    return dataclasses.replace(entry, **changes)


@for_each(
    "entry",
    [
        _listing("x"),
        _listing("x, x"),
        _listing("x, class"),
        _listing("x, __init__"),
        _listing("x, y}"),
        _listing("x, y{"),
        _listing("x; y"),
        _listing("x, y, " + "junk! " * 10),
        _listing("a{" * 50_000),
        _listing("a{" * 1000),
        _listing("x, " + " " * 20_000 + "y"),
        _listing("x, y", "{int,{int}}"),
        _listing("x, y", "{uint,<{int}:1>}"),
        _listing("x, y{z", "{int,{int}}"),
        _listing("x, y*{z", "{int,*{int}}"),
        _listing("*x, y", "{int,int}"),
        _listing("x, y", "{int"),
        _listing("x, y", name="no name"),
        _listing("x, y", name="M" * 100_000),
        _listing("x, y", keep="some"),
        _listing("x, y", plane="astral"),
    ],
)
def test_listing_that_describes_no_message_is_refused(entry: control.Define) -> None:
    with pytest.raises(MessageFormatError) as caught:
        from_listing(entry)
    assert len(str(caught.value)) < 500


@given(st.text(max_size=40) | st.text("ab{}[], ", max_size=40), st.sampled_from(["{}", "{int}"]))
def test_any_fields_are_taken_or_refused(fields: str, text: str) -> None:
    try:
        from_listing(_listing(fields, text))
    except MessageFormatError:
        return
    assert fields.strip(", ") == "" or text == "{int}"


def test_arrays_of_a_decoded_value_are_numpy_views() -> None:
    @dataclass(frozen=True, slots=True, kw_only=True)
    class Scan:
        ranges: np.ndarray

    definition = define(Scan, "{[float:3]}")
    back = definition.decode(payload(definition, Scan(ranges=[1, 2, 3])))
    assert back.ranges.dtype == np.float32
    assert back.ranges.tolist() == [1, 2, 3]


@for_each(
    ("definition", "value"),
    [(PATH, _VALUE), (TOUR, _TOUR), (TOUR, _NO_TOUR), (ROUTE, _ROUTE)],
)
def test_mapping_with_the_names_of_the_fields_is_as_good_as_the_dataclass(
    definition: MessageDefinition[Any], value: Any
) -> None:
    assert payload(definition, plain(value)) == payload(definition, value)
    read_only = types.MappingProxyType(dict(reversed(plain(value).items())))
    assert payload(definition, read_only) == payload(definition, value)


def test_fields_named_like_the_methods_of_a_mapping_are_no_trap() -> None:
    assert payload(ODD, {"items": 1, "get": {"x": 2, "y": 3}}).hex() == (
        "00010000010000000200000003000000"
    )


@for_each(
    ("changes", "reason"),
    [
        ({"zzz": None}, "Tour has no field 'zzz'; it has route, home"),
        ({"hme": None, "home": ...}, r"Tour has no field 'hme'; did you mean 'home'\?"),
        ({"stop": None, "home": ...}, "Tour has no field 'stop'; it has route, home"),
        ({"home": ...}, "Tour needs a value for home$"),
        ({"home": ..., "hint": ...}, "Tour needs a value for home, hint$"),
        ({"home": {"x": 1, "z": 2}}, r"Tour.home has no field 'z'; .*y"),
        ({"home": {"x": 1}}, "Tour.home needs a value for y"),
        ({"route": {"place": {"x": 1}, "next": None}}, "Tour.route.place needs a value for y"),
        ({5: 6}, "Tour has no field '5'"),
        ({"home": [1, 2]}, "Tour.home: list is not a Point"),
        ({"count": None}, "integer"),
    ],
)
def test_mapping_with_other_names_is_refused_with_the_nearest(
    changes: dict[Any, Any], reason: str
) -> None:
    members = {name: value for name, value in (plain(_TOUR) | changes).items() if value != ...}
    with pytest.raises(CodecError, match=reason):
        TOUR.encode(members)


def test_long_list_comes_back_and_a_longer_one_or_a_circle_is_refused() -> None:
    first = None
    for number in range(formats.MAX_NODES):
        first = Waypoint(place=Point(x=number, y=0), next=first)
    assert first is not None
    back: Waypoint | None = ROUTE.decode(payload(ROUTE, first))
    places = []
    while back is not None:
        places.append(back.place.x)
        back = back.next
    assert places == list(reversed(range(formats.MAX_NODES)))
    with pytest.raises(CodecError, match="longer than 10000 nodes"):
        ROUTE.encode(Waypoint(place=Point(x=0, y=0), next=first))
    circle: dict[str, Any] = {"place": {"x": 1, "y": 2}}
    circle["next"] = circle
    with pytest.raises(CodecError, match="in a circle"):
        ROUTE.encode(circle)
    members: list[Any] = [(1, 2), None]
    members[1] = members
    with pytest.raises(CodecError, match="in a circle"):
        ROUTE.build(members)


@for_each("members", [None, False, [], (1,), ((1, 2), 3), ((1,), None), {1: None}])
def test_values_that_are_no_list_are_refused(members: Any) -> None:
    with pytest.raises(CodecError):
        ROUTE.build(members)


def test_type_whose_hints_cannot_be_found_is_refused() -> None:
    @dataclass(frozen=True, slots=True, kw_only=True)
    class Local:
        text: Unknown  # type: ignore[name-defined]  # noqa: F821

    with pytest.raises(MessageFormatError, match="the types of Local's fields cannot be found"):
        define(Local, "{string}")


def test_a_definition_reads_the_types_of_its_fields_at_first_use() -> None:
    @dataclass(frozen=True, slots=True, kw_only=True)
    class Local:
        text: Unknown  # type: ignore[name-defined]  # noqa: F821

    definition = MessageDefinition(name="T_Local", type=Local)
    with pytest.raises(MessageFormatError, match="the types of Local's fields cannot be found"):
        _ = definition.fingerprint
