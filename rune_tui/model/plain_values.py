"""Immutable values of the console as JSON, and back by their types; exact, and pure.

| value | in JSON |
| --- | --- |
| None, bool, int, str, finite float | itself |
| another float | "nan", "inf" or "-inf" |
| enum | the name of the member |
| dataclass | an object |
| tuple, frozenset | an array |
| mapping | an array of pairs |
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import json
import math
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rune_tui.errors import LogError

LONGEST = 4 << 20
"""Most letters of a value that is read back."""


def to_json(value: object) -> str:
    """A value as JSON."""
    return json.dumps(_plain(value), separators=(",", ":"), ensure_ascii=False)


def from_json(kind: Any, text: str) -> Any:
    """The value of a type in JSON.

    Raises:
        LogError: It is no value of that type.
    """
    if len(text) > LONGEST:
        reason = f"a value of {len(text)} letters is longer than {LONGEST}"
        raise LogError(reason)
    try:
        return _value(kind, json.loads(text))
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        reason = f"{text[:60]!r} is no value of {kind}: {error}"
        raise LogError(reason) from error


def _plain(value: object) -> object:
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else repr(float(value))
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, Mapping):
        return [[_plain(key), _plain(each)] for key, each in value.items()]
    if dataclasses.is_dataclass(value):
        return {each.name: _plain(getattr(value, each.name)) for each in dataclasses.fields(value)}
    if isinstance(value, frozenset):
        return sorted((_plain(each) for each in value), key=repr)
    if isinstance(value, Iterable):
        return [_plain(each) for each in value]
    text = f"{type(value).__name__} is no plain value"
    raise TypeError(text)


def _value(kind: Any, plain: Any) -> Any:
    return _reader(kind)(plain)


@functools.cache
def _reader(kind: Any) -> Callable[[Any], Any]:
    """The function that reads values of a type."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        given = [each for each in inner if each is not types.NoneType]
        return lambda plain: None if plain is None else _value(given[0], plain)
    if origin is tuple and len(inner) == 2 and inner[1] is Ellipsis:
        return lambda plain: tuple(_value(inner[0], each) for each in _array(plain))
    if origin is tuple:
        return lambda plain: tuple(
            _value(each, value) for each, value in zip(inner, _array(plain), strict=True)
        )
    if origin is frozenset:
        return lambda plain: frozenset(_value(inner[0], each) for each in _array(plain))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return lambda plain: {
            _value(inner[0], key): _value(inner[1], each) for key, each in _array(plain)
        }
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        return lambda plain: kind[plain]
    if dataclasses.is_dataclass(kind):
        return functools.partial(_dataclass, kind)
    return functools.partial(_simple, kind)


def _array(plain: object) -> list[Any]:
    if not isinstance(plain, list):
        text = f"{plain!r:.40} is no array"
        raise TypeError(text)
    return plain


def _dataclass(kind: Any, plain: Any) -> Any:
    """A dataclass; fields that the text lacks have their defaults, others are left out."""
    if not isinstance(plain, dict):
        text = f"{plain!r:.40} is no object"
        raise TypeError(text)
    hints = _hints(kind)
    given = {name: _value(hints[name], each) for name, each in plain.items() if name in hints}
    return kind(**given)


@functools.cache
def _hints(kind: Any) -> dict[str, Any]:
    return typing.get_type_hints(kind)


def _simple(kind: Any, plain: Any) -> Any:
    if kind is float and isinstance(plain, str):
        return float(plain)
    # A whole number stays one where a float is meant: it was one.
    allowed = (float, int) if kind is float else (kind,)
    if isinstance(plain, allowed) and (kind is bool or not isinstance(plain, bool)):
        return plain
    text = f"{plain!r:.40} is no {kind.__name__}"
    raise TypeError(text)
