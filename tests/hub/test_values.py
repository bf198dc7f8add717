"""Value classes: as dataclasses of the standard library, whichever method is used first."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError, field
from typing import Any, ClassVar

import pytest

from hub.values import Making, dataclass
from tests.support.cases import for_each


@pytest.fixture(autouse=True)
def _methods_are_made_late(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in the console, whatever other tests of this process have imported."""
    monkeypatch.setattr(Making, "at_once", False)


def _point_class() -> type:
    @dataclass(frozen=True, slots=True, kw_only=True)
    class Point:
        x: float
        y: float = 2.0
        notes: list[str] = field(default_factory=list, compare=False)
        unit: ClassVar = "m"

        def __post_init__(self) -> None:
            object.__setattr__(self, "x", float(self.x))

    return Point


FIRST_USES: dict[str, Callable[[type], object]] = {
    "made": lambda kind: kind(x=1).y,
    "shown": lambda kind: repr(bare(kind)),
    "compared": lambda kind: bare(kind) == bare(kind),
    "hashed": lambda kind: hash(bare(kind)),
    "changed": lambda kind: dataclasses.replace(bare(kind), x=3),
}


def bare(kind: type) -> Any:
    """A value that no `__init__` made."""
    value: Any = object.__new__(kind)
    for name, each in {"x": 1.0, "y": 2.0, "notes": []}.items():
        object.__setattr__(value, name, each)
    return value


@for_each("use", FIRST_USES)
def test_each_first_use_completes_the_class(use: str) -> None:
    point = _point_class()
    FIRST_USES[use](point)
    one = point(x=1)
    assert (one.x, one.y, one.notes, one.unit) == (1.0, 2.0, [], "m")
    assert one == point(x=1, notes=["seen"])
    assert one != point(x=1, y=3.0)
    assert hash(one) == hash(point(x=1))
    assert repr(one).endswith("Point(x=1.0, y=2.0, notes=[])")
    assert point.__init__.__qualname__.endswith("Point.__init__")
    with pytest.raises(TypeError, match="positional"):
        point(1)
    with pytest.raises(TypeError, match="missing 1 required keyword-only argument: 'x'"):
        point()


def test_a_value_keeps_its_fields_and_has_no_others() -> None:
    value = _point_class()(x=1)
    for name in ("x", "other"):
        with pytest.raises(FrozenInstanceError, match=name):
            setattr(value, name, 5.0)
        with pytest.raises(FrozenInstanceError, match=name):
            delattr(value, name)
    assert not hasattr(value, "__dict__")


@dataclass(frozen=True, slots=True)
class Pose:
    """At module level, where pickle finds it."""

    x: float
    theta: float = 0.0


@dataclass(frozen=True, slots=True)
class NamedPose(Pose):
    """A subclass with methods of its own."""

    name: str = ""

    def __repr__(self) -> str:
        return self.name

    def __hash__(self) -> int:
        return len(self.name)


def test_values_are_copied_and_pickled() -> None:
    pose = Pose(1.0, 2.0)
    assert copy.copy(pose) == pickle.loads(pickle.dumps(pose)) == copy.deepcopy(pose) == pose


def test_a_subclass_keeps_the_methods_that_it_defines() -> None:
    pose = NamedPose(1.0, name="home")
    assert repr(pose) == "home"
    assert pose == NamedPose(1.0, name="home")
    assert pose != NamedPose(1.0, name="away")
    assert dataclasses.astuple(pose) == (1.0, 0.0, "home")
    assert hash(pose) == len("home")
    assert Pose(1.0) != pose


def test_a_class_without_comparison_is_compared_by_identity() -> None:
    @dataclass(frozen=True, kw_only=True, eq=False)
    class Handle:
        name: str

    one = Handle(name="a")
    assert one != Handle(name="a")
    assert len({one, Handle(name="a")}) == 2


def test_a_subclass_makes_its_methods_when_its_base_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Making, "at_once", True)

    @dataclass(frozen=True, slots=True)
    class Place:
        x: float

    @dataclass(frozen=True, slots=True)
    class NamedPlace(Place):
        name: str

    @dataclass(frozen=True, slots=True)
    class Turn(Pose):
        limit: float = 1.0

    for place in (NamedPlace(1.0, "home"), Turn(1.0)):
        with pytest.raises(FrozenInstanceError):
            place.x = 2.0  # type: ignore[misc]
    assert "x" in Place.__init__.__code__.co_varnames
    assert repr(NamedPlace(1.0, "home")).endswith("NamedPlace(x=1.0, name='home')")
    assert Turn(1.0) == Turn(1.0)


def test_mutable_and_ordered_classes_are_those_of_the_standard_library() -> None:
    @dataclass(slots=True)
    class Counter:
        count: int = 0

    @dataclass(frozen=True, slots=True, order=True)
    class Version:
        number: int

    counter = Counter()
    counter.count += 1
    assert counter == Counter(1)
    assert Version(1) < Version(2)
