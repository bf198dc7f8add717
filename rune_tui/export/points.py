"""Interest points as CSV (RFC 4180) and GeoJSON (RFC 7946); pure."""

from __future__ import annotations

import base64
import datetime
import math
from collections.abc import Sequence
from typing import Any

from hub.gcm.mapping import InterestPoint
from hub.table_text import csv_line, json_text
from rune_tui.model.world import metres_text

COLUMNS = (
    "number", "kind", "x_m", "y_m", "uncertainty_m", "distance_m", "time", "by", "note",
)  # fmt: skip
"""Columns of the table; x and y in `map`, time in UTC (ISO 8601); an unknown value is empty."""
_JPEG = b"\xff\xd8"


def csv_table(points: Sequence[InterestPoint]) -> str:
    """A table with a line for each point."""
    lines = [csv_line(COLUMNS)]
    for point in points:
        place = (f"{point.x:.3f}", f"{point.y:.3f}")
        sure = (metres_text(point.uncertainty, 3), metres_text(point.distance, 3))
        when = moment(point.stamp)
        lines.append(
            csv_line(
                (point.number, point.kind.name.lower(), *place, *sure, when, point.by, point.note)
            )
        )
    return "".join(lines)


def _coordinates(point: InterestPoint) -> list[float]:
    return [point.x, point.y, *([point.height] if point.height else [])]


def geojson(points: Sequence[InterestPoint], robot: str) -> str:
    """A FeatureCollection, which a hub's mapping module can read too.

    The coordinates are metres in the robot's `map`, not degrees on the earth, as the member
    "frame" says. The third one is the height above the floor. An unknown value is null.
    """
    features: list[dict[str, Any]] = [
        {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": _coordinates(point)},
            "properties": {
                "number": point.number,
                "kind": point.kind.name.lower(),
                "uncertainty": _known(point.uncertainty),
                "distance": _known(point.distance),
                "stamp": point.stamp,
                "time": moment(point.stamp),
                "by": point.by,
                "note": point.note,
                "thumbnail": thumbnail_text(point),
            },
        }
        for point in points
        if math.isfinite(point.x) and math.isfinite(point.y) and math.isfinite(point.stamp)
    ]
    collection = {
        "type": "FeatureCollection",
        "frame": "map",
        "robot": robot,
        "features": features,
    }
    return json_text(collection, indent=1, ensure_ascii=False) + "\n"


def moment(stamp: float) -> str:
    """A time [s since the epoch] as text; empty if invalid."""
    try:
        when = datetime.datetime.fromtimestamp(stamp, datetime.UTC)
    except (ValueError, OverflowError, OSError):
        return ""
    return when.isoformat(timespec="seconds").replace("+00:00", "Z")


def thumbnail_text(point: InterestPoint) -> str:
    """The JPEG file of a point in base64; empty if there is none."""
    raw = point.thumbnail.tobytes()
    return base64.b64encode(raw).decode() if raw.startswith(_JPEG) else ""


def _known(metres: float) -> float | None:
    return metres if math.isfinite(metres) else None
