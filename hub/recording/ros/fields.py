"""The fields of any message as rows, and the numbers in them over time."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.plain_text import plain
from hub.recording.ros.topic_values import TopicMessages
from hub.ros.decoding import RosDecoder
from hub.ros.schema import TEXT, RosType
from hub.ros.values import RosValue
from hub.values import dataclass

MOST_ROWS: Final = 1000
MOST_SAMPLES: Final = 4000
"""Most numbers of a series."""
_MOST_BYTES: Final = 1 << 26
"""Most bytes that are read for a series."""
_SPREAD: Final = 16
"""Arrays of more elements have one row."""
_SHOWN: Final = 4
_DEEPEST: Final = 8
_TIMES: Final = (
    "std_msgs/msg/Header",
    "builtin_interfaces/msg/Time",
    "builtin_interfaces/msg/Duration",
)
_MOST_DEPTH: Final = 40
_LONGEST: Final = 200
_TIME = re.compile(r"(?:^|[._])(?:header|stamp|timestamp|time|n?sec|seconds|nanos)(?:\.|$)")
_STEP = re.compile(r"([A-Za-z]\w*)((?:\[\d{1,9}\])*)", re.ASCII)


@dataclass(frozen=True, slots=True)
class FieldRow:
    """A field of a message.

    Attributes:
        path: As in `twist.linear.x` or `status[0].name`.
        text: Its value.
        number: Its value as a number; NaN: it is none.
    """

    path: str
    text: str
    number: float = math.nan


def field_rows(value: RosValue) -> tuple[FieldRow, ...]:
    """The fields of a message with those within it, the first `MOST_ROWS`."""
    return tuple(itertools.islice(_rows("", value), MOST_ROWS))


def first_field(bag: TopicMessages, channel: int, decoder: RosDecoder | None) -> str:
    """Path of the first number of a topic that is no time; empty: it has none.

    Args:
        bag: The recording.
        channel: The topic.
        decoder: Its decoder; None: it cannot be read.
    """
    if decoder is None:
        return ""
    if decoder.type is not None:
        return _first_number(decoder.type)
    message = bag.newest(bag.end, {channel}).get(channel)
    try:
        rows = field_rows(decoder.decode(message.payload)) if message is not None else ()
    except RosMessageError:
        return ""
    numbers = (each.path for each in rows if math.isfinite(each.number))
    return next((path for path in numbers if not _TIME.search(path)), "")


def _first_number(kind: RosType, depth: int = 0) -> str:
    """Path of the first number of a type that is no time; empty: it has none.

    Arrays come last: their first element says less.
    """
    if kind.name in _TIMES or depth > _DEEPEST:
        return ""
    for many in (False, True):
        for each in kind.fields:
            if (each.count is not None) is not many:
                continue
            path = f"{each.name}[0]" if many else each.name
            if isinstance(each.kind, RosType):
                inner = _first_number(each.kind, depth + 1)
                if inner:
                    return f"{path}.{inner}"
            elif each.kind != TEXT:
                return path
    return ""


def number_at(value: RosValue, path: str) -> float:
    """The number at a path; NaN: there is none."""
    found: Any = value
    for step in path.split("."):
        match = _STEP.fullmatch(step)
        found = found.field(match[1]) if match and isinstance(found, RosValue) else None
        for number in re.findall(r"\d+", match[2]) if match else ():
            many = isinstance(found, tuple | np.ndarray) and int(number) < len(found)
            found = found[int(number)] if many else None
    if isinstance(found, np.ndarray) and found.size > _SPREAD:
        return float(np.nanmin(found)) if np.isfinite(found).any() else math.nan
    return float(found) if isinstance(found, int | float | np.number | np.bool_) else math.nan


def _rows(path: str, value: Any) -> Iterator[FieldRow]:  # noqa: ANN401 - fields have any type
    if isinstance(value, tuple | np.ndarray) and len(value) > _SPREAD:
        yield FieldRow(path, _summary(value), _least(value))
    elif isinstance(value, RosValue | tuple | np.ndarray):
        inner = _parts(path, value)
        first = next(inner, None)
        if first is None or path.count(".") + path.count("[") > _MOST_DEPTH:
            yield FieldRow(path, "empty" if first is None else "…")
            return
        for name, each in itertools.chain((first,), inner):
            yield from _rows(name, each)
    elif isinstance(value, str):
        yield FieldRow(path, plain(value[:_LONGEST]))
    elif value is None:
        yield FieldRow(path, "none")
    else:
        number = float(value)
        exact = isinstance(value, int | np.integer | np.bool_)
        yield FieldRow(path, str(value) if exact else f"{number:.6g}", number)


def _parts(path: str, value: Any) -> Iterator[tuple[str, Any]]:  # noqa: ANN401 - as above
    """Paths and values of what is within a value."""
    if isinstance(value, RosValue):
        for name, inner in value.fields():
            yield f"{path}.{name}" if path else plain(name[:_LONGEST]), inner
    else:
        for place, inner in enumerate(value):
            yield f"{path}[{place}]", inner


def _summary(value: tuple[Any, ...] | npt.NDArray[Any]) -> str:
    if not isinstance(value, np.ndarray):
        return f"{len(value)} elements"
    first = " ".join(f"{float(each):.4g}" for each in value[:_SHOWN])
    return f"{first} … {len(value)} numbers, least {_least(value):.4g}"


def _least(value: tuple[Any, ...] | npt.NDArray[Any]) -> float:
    if not isinstance(value, np.ndarray) or not np.isfinite(value).any():
        return math.nan
    return float(np.min(value[np.isfinite(value)]))


class FieldSeries:
    """A number of a topic over the last seconds, read again only where it has to be."""

    def __init__(
        self, bag: TopicMessages, channel: int, decoder: RosDecoder, path: str, span: int
    ) -> None:
        """Begin without numbers.

        Args:
            bag: The recording.
            channel: The topic.
            decoder: Its decoder.
            path: The field.
            span: Length of the series [ns].
        """
        self._bag, self._channel, self._decoder = bag, channel, decoder
        self._path, self._span = path, span
        self._known: list[tuple[int, float]] = []
        self._at: int | None = None

    def until(self, stamp: int) -> list[tuple[int, float]]:
        """Stamps [ns] and numbers of the last `span` before a time, the newest `MOST_SAMPLES`."""
        since = stamp - self._span
        ahead = self._at is not None and self._at <= stamp <= self._at + self._span
        if not ahead:
            self._known = []
        start = self._at + 1 if ahead and self._at is not None else since
        new: list[tuple[int, float]] = []
        size = 0
        back = self._bag.messages(max(0, start), stamp, {self._channel}, reverse=True)
        for message in itertools.islice(back, MOST_SAMPLES):
            size += len(message.payload)
            if size > _MOST_BYTES:
                break
            new.append((message.stamp, self._number(message.payload)))
        self._at = stamp
        self._known = [*(each for each in self._known if each[0] >= since), *reversed(new)]
        del self._known[:-MOST_SAMPLES]
        return self._known

    def _number(self, payload: bytes) -> float:
        try:
            return number_at(self._decoder.decode(payload), self._path)
        except RosMessageError:
            return math.nan
