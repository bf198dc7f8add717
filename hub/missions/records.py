"""The records of a journal, as values and as JSON objects of its lines; pure."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any, get_args

from hub.errors import MapFileError, MissionFileError
from hub.gcm.mapping import InterestPoint
from hub.missions import point_file
from hub.missions.point_file import has_half
from hub.missions.points import MAX_NUMBER, NO_THUMBNAIL
from hub.values import dataclass

MAX_NAME = 64
"""Largest number of characters of the name of a mission or an operator."""
MAX_TEXT = 500
"""Characters of an event."""
_MAX_STAMP = 1e10
_FORMAT = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Begun:
    """The mission was begun; the first record.

    Attributes:
        robot: Name of the robot.
        name: The operator's name for the mission.
        by: The operator who started it.
        stamp: When [s since the epoch].
    """

    robot: str
    name: str
    by: str
    stamp: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Named:
    """The mission has another name.

    Attributes:
        name: That.
        by: The operator who named it.
        stamp: When [s since the epoch].
    """

    name: str
    by: str
    stamp: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SheetBegun:
    """A new sheet of the map: places on it and on the sheets before cannot be compared.

    Attributes:
        number: Of the sheet, from 1.
        frame: Number of the frame `map`, from the robot's state; 0: not known yet.
        carries: Whether the marks of the sheet before are valid on it.
        why: For people.
        stamp: When [s since the epoch].
    """

    number: int
    frame: int
    carries: bool
    why: str
    stamp: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameKnown:
    """The frame of the newest sheet became known.

    Attributes:
        frame: Its number.
    """

    frame: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Marked:
    """A point was marked or changed on the newest sheet.

    Attributes:
        point: As it is from now on.
        stamp: When [s since the epoch]; a changed point keeps the time when it was first marked.
        same_thumbnail: Whether the picture is that of the point before; the journal omits it then.
    """

    point: InterestPoint
    stamp: float
    same_thumbnail: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Removed:
    """A point was removed.

    Attributes:
        number: Its number.
        by: The operator who removed it.
        stamp: When [s since the epoch].
    """

    number: int
    by: str
    stamp: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Noted:
    """Something happened.

    Attributes:
        text: One sentence.
        stamp: When [s since the epoch].
    """

    text: str
    stamp: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """The mission was ended; the last record.

    Attributes:
        by: The operator who ended it.
        stamp: When [s since the epoch].
    """

    by: str
    stamp: float


Record = Begun | Named | SheetBegun | FrameKnown | Marked | Removed | Noted | Ended


def to_json(record: Record) -> dict[str, Any]:
    """The JSON object of a record."""
    kind = type(record).__name__.lower()
    if isinstance(record, Marked):
        point = record.point
        same = {"same_thumbnail": True} if record.same_thumbnail else {}
        if same:
            point = dataclasses.replace(point, thumbnail=NO_THUMBNAIL)
        feature = point_file.feature_of(point)
        return {"is": kind, "point": feature, "stamp": record.stamp, **same}
    first = {"format": _FORMAT} if isinstance(record, Begun) else {}
    return {"is": kind, **first, **dataclasses.asdict(record)}


def from_json(values: dict[str, Any]) -> Record:
    """The record of a JSON object.

    Raises:
        MissionFileError: It is none, or a value is not within its bounds.
    """
    kind = _KINDS.get(str(values.get("is"))[:40])
    if kind is None:
        text = f"the journal has a record {str(values.get('is'))[:40]!r}, which nobody knows"
        raise MissionFileError(text)
    if kind is Begun and _whole(values, "format") != _FORMAT:
        text = f"the journal is of form {values['format']}; this Rune reads form {_FORMAT}"
        raise MissionFileError(text)
    try:
        fields = [field.name for field in dataclasses.fields(kind)]
        return kind(**{name: _READERS[name](values, name) for name in fields})
    except MapFileError as error:
        raise MissionFileError(str(error)) from error


def _text(values: dict[str, Any], key: str, longest: int = MAX_NAME) -> str:
    text = values.get(key)
    if not isinstance(text, str) or len(text) > longest or "\0" in text or has_half(text):
        reason = f"the journal has {key!r} that is no text of at most {longest} characters"
        raise MissionFileError(reason)
    return text


def _whole(values: dict[str, Any], key: str) -> int:
    number = values.get(key)
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= MAX_NUMBER:
        text = f"the journal has {key!r} that is no whole number from 0 to {MAX_NUMBER}"
        raise MissionFileError(text)
    return number


def _stamp(values: dict[str, Any], key: str) -> float:
    stamp = values.get(key)
    if isinstance(stamp, bool) or not isinstance(stamp, int | float):
        stamp = -1.0
    if not 0.0 <= stamp <= _MAX_STAMP:
        text = "the journal has a time that cannot be"
        raise MissionFileError(text)
    return float(stamp)


def _truth(values: dict[str, Any], key: str) -> bool:
    return values.get(key) is True


_READERS: dict[str, Callable[[dict[str, Any], str], Any]] = {
    **dict.fromkeys(("robot", "name", "by"), _text),
    **dict.fromkeys(("why", "text"), functools.partial(_text, longest=MAX_TEXT)),
    **dict.fromkeys(("number", "frame"), _whole),
    **dict.fromkeys(("carries", "same_thumbnail"), _truth),
    "stamp": _stamp,
    "point": lambda values, key: point_file.point_of(values.get(key)),
}
"""How a field of a record is read, by its name."""
_KINDS: dict[str, type[Record]] = {kind.__name__.lower(): kind for kind in get_args(Record)}
