"""How much of a message the console takes; robots are not trusted, so what is too much is left out.

What passes here can be drawn at once: no number is too large to be counted in, no word or list too
long to be looked at 30 times a second.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Final, TypeVar

import numpy as np

from hub.gcm.mapping import InterestPoint

LARGEST: Final = 1e10
"""No finite number of a message is larger: seconds since the epoch until the year 2286, metres."""
MOST_ENTRIES: Final = 1000
"""Entries of a list."""
MOST_LETTERS: Final = 1000
"""Letters of a text."""

_LENGTHS: Final = {InterestPoint: ("uncertainty", "distance")}
"""Fields that no robot can mean to be negative or without end [m]."""

T = TypeVar("T")


def bounded(value: T) -> T:
    """A message's value within the bounds.

    Lists and texts are cut at their ends. A finite number beyond `LARGEST` becomes NaN, which all
    messages have for what is not known, and so does a length that cannot be. What is within the
    bounds comes back as it is.
    """
    kept: Any = value
    if isinstance(value, float):
        kept = math.nan if LARGEST < abs(value) < math.inf else value
    elif isinstance(value, str):
        kept = value[:MOST_LETTERS]
    elif isinstance(value, tuple):
        kept = _entries(value)
    elif isinstance(value, np.ndarray):
        kept = _numbers(value)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        kept = _fields(value)
    return kept  # type: ignore[no-any-return]  # of the type that came in


def _entries(value: tuple[Any, ...]) -> tuple[Any, ...]:
    kept = [bounded(entry) for entry in value[:MOST_ENTRIES]]
    same = len(kept) == len(value) and all(a is b for a, b in zip(kept, value, strict=True))
    return value if same else tuple(kept)


def _numbers(value: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    if value.dtype.kind != "f":
        return value
    wild = np.isfinite(value) & (np.abs(value) > LARGEST)
    return np.where(wild, np.nan, value).astype(value.dtype) if wild.any() else value


def _fields(value: Any) -> Any:  # noqa: ANN401 - messages have many types
    changes = {}
    lengths = _LENGTHS.get(type(value), ())
    for field in dataclasses.fields(value):
        before = getattr(value, field.name)
        after = bounded(before)
        if field.name in lengths and (after < 0.0 or after == math.inf):
            after = math.nan
        if after is not before:
            changes[field.name] = after
    return dataclasses.replace(value, **changes) if changes else value
