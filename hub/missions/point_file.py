"""Interest points as GeoJSON (RFC 7946) and back; pure.

The coordinates are metres in `map`, not degrees on the earth, as the member "frame" says: the form
is GeoJSON's, so that tools show the points over the map, with the map's own frame as the plane.
"""

from __future__ import annotations

import base64
import json
import math
from typing import Any, NoReturn

import numpy as np

from hub.errors import MapFileError
from hub.gcm.mapping import InterestPoint, PointKind
from hub.missions.points import (
    FARTHEST,
    LATEST,
    MAX_BY,
    MAX_NOTE,
    MAX_NUMBER,
    MAX_POINTS,
    MAX_THUMBNAIL_BYTES,
)

MAX_BYTES = 4 << 20
"""Of a file of points; the largest that is written is much smaller."""

_KINDS = {kind.name.lower(): kind for kind in PointKind}


def encode_points(points: tuple[InterestPoint, ...]) -> bytes:
    """The file of these points."""
    features = [feature_of(point) for point in points]
    collection = {"type": "FeatureCollection", "frame": "map", "features": features}
    return (json.dumps(collection, indent=1, ensure_ascii=False) + "\n").encode()


def feature_of(point: InterestPoint) -> dict[str, Any]:
    """A point as a GeoJSON feature."""
    return {
        "type": "Feature",
        "geometry": {"type": "Point", "coordinates": _coordinates(point)},
        "properties": {
            "number": point.number,
            "kind": point.kind.name.lower(),
            "uncertainty": _known(point.uncertainty),
            "distance": _known(point.distance),
            "stamp": point.stamp,
            "by": point.by,
            "note": point.note,
            "thumbnail": base64.b64encode(point.thumbnail.tobytes()).decode(),
            "version": point.version,
        },
    }


def _coordinates(point: InterestPoint) -> list[float]:
    """Where it is [m], with its height where it is not on the floor."""
    return [point.x, point.y, *([point.height] if point.height else [])]


def decode_points(raw: bytes) -> tuple[InterestPoint, ...]:
    """The points of a file.

    Raises:
        MapFileError: It is too large, is no GeoJSON, or a point is not within its bounds.
    """
    if len(raw) > MAX_BYTES:
        _refuse(f"is larger than {MAX_BYTES} bytes")
    try:
        collection = json.loads(raw.decode(), parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        text = f"the points are no JSON: {error}"
        raise MapFileError(text) from error
    features = _member(collection, "features", list)
    if collection.get("type") != "FeatureCollection" or len(features) > MAX_POINTS:
        _refuse(f"are no FeatureCollection of at most {MAX_POINTS} features")
    points = tuple(point_of(feature) for feature in features)
    if len({point.number for point in points}) < len(points):
        _refuse("have a number twice")
    return points


def _known(metres: float) -> float | None:
    """A length as JSON has it [m]: JSON has no NaN."""
    return None if math.isnan(metres) else metres


def point_of(feature: Any) -> InterestPoint:  # noqa: ANN401 - any JSON value
    """The point of a GeoJSON feature.

    Raises:
        MapFileError: It is none, or not within its bounds.
    """
    geometry = _member(feature, "geometry", dict)
    place = _member(geometry, "coordinates", list)
    if geometry.get("type") != "Point" or len(place) not in (2, 3):
        _refuse("have one that is no Point")
    properties = _member(feature, "properties", dict)
    kind = _KINDS.get(_text(properties, "kind", 32))
    if kind is None:
        _refuse(f"have one that is none of {', '.join(_KINDS)}")
    number = _number(properties.get("number"), 1, MAX_NUMBER)
    if number != int(number):
        _refuse("have a number that is not whole")
    thumbnail = _thumbnail(properties)
    return InterestPoint(
        number=int(number),
        kind=kind,
        x=_number(place[0], -FARTHEST, FARTHEST),
        y=_number(place[1], -FARTHEST, FARTHEST),
        uncertainty=_length(properties.get("uncertainty")),
        distance=_length(properties.get("distance")),
        stamp=_number(properties.get("stamp", 0), 0.0, LATEST),
        by=_text(properties, "by", MAX_BY),
        note=_text(properties, "note", MAX_NOTE),
        thumbnail=np.frombuffer(thumbnail, np.uint8),
        version=int(_number(properties.get("version", 1), 0, MAX_NUMBER)),
        kept=1,
        height=_number(place[2], -FARTHEST, FARTHEST) if len(place) == 3 else 0.0,
    )


def _member(value: Any, name: str, kind: type) -> Any:  # noqa: ANN401 - any JSON value
    member = value.get(name) if isinstance(value, dict) else None
    if not isinstance(member, kind):
        _refuse(f"lack {name!r} where it belongs")
    return member


def _number(value: object, low: float, high: float) -> float:
    # Compared before it is converted: a whole number may have thousands of digits.
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        _refuse(f"have a number that is not between {low:g} and {high:g}")
    return float(value)


def _length(value: object) -> float:
    """A length [m]; NaN: the file has none, as files of other programs."""
    return math.nan if value is None else _number(value, 0.0, FARTHEST)


def _text(properties: dict[str, Any], name: str, longest: int) -> str:
    """A text that can also be sent; empty if there is none."""
    text = properties.get(name, "")
    if not isinstance(text, str) or len(text) > longest or "\0" in text or has_half(text):
        _refuse(f"have {name!r} that is no text of at most {longest} characters")
    return text


def has_half(text: str) -> bool:
    """Whether half of a surrogate pair is in it, which no UTF-8 can say."""
    return any("\ud800" <= character <= "\udfff" for character in text)


def _thumbnail(properties: dict[str, Any]) -> bytes:
    coded = _text(properties, "thumbnail", 2 * MAX_THUMBNAIL_BYTES)
    try:
        thumbnail = base64.b64decode(coded, validate=True)
    except ValueError as error:
        text = f"the points have a thumbnail that is no base64: {error}"
        raise MapFileError(text) from error
    if len(thumbnail) > MAX_THUMBNAIL_BYTES:
        _refuse(f"have a thumbnail of more than {MAX_THUMBNAIL_BYTES} bytes")
    return thumbnail


def _no_number(name: str) -> NoReturn:
    text = f"{name} is no number"
    raise ValueError(text)


def _refuse(reason: str) -> NoReturn:
    text = f"the points {reason}"
    raise MapFileError(text)
