"""A mission as files that other programs read: maps, marks, pictures, track, events."""

from __future__ import annotations

import enum
import math
import time
from pathlib import Path
from typing import Any

import numpy as np

from hub import files
from hub.errors import MissionFileError
from hub.gcm.mapping import InterestPoint
from hub.gcm.occupancy_map import OccupancyMap
from hub.missions import journal_file, point_file, ros_map
from hub.missions.book import MissionBook
from hub.missions.folder import MissionFolder
from hub.missions.log_odds import LogOdds
from hub.table_text import csv_line

_KNOWN = 0.1
"""A cell with less evidence than this is unknown [log-odds]."""
_BY_SHEETS = ("number", "sheet", "kind", "x", "y", "uncertainty", "distance", "time", "by", "note")


def export(folder: MissionFolder, mission: str, target: Path) -> list[Path]:
    """Write a mission into a new or empty folder.

    Returns:
        The files.

    Raises:
        MissionFileError: The mission cannot be read, or the folder not written.
    """
    book, _ = folder.read(mission)
    found: list[Path] = []
    try:
        target.mkdir(parents=True, exist_ok=True)
        if any(target.iterdir()):
            text = f"{target} is not empty; name another folder with --output"
            raise MissionFileError(text)
        for name, content in _contents(folder, mission, book):
            files.replace(target / name, content)
            found.append(target / name)
    except OSError as fault:
        text = f"{target} cannot be written: {fault.strerror or fault}; name another with --output"
        raise MissionFileError(text) from fault
    return found


def marks_of(book: MissionBook) -> list[tuple[int, InterestPoint]]:
    """All marks of a mission with their sheets, in the order of their numbers."""
    marks = [*book.points.earlier.values(), *((book.sheet, p) for p in book.points.points)]
    return sorted(marks, key=lambda mark: mark[1].number)


def track_of(folder: MissionFolder, mission: str) -> list[dict[str, Any]]:
    """The poses of a mission; none where there is no track."""
    path = folder.track_of(mission)
    poses: list[dict[str, Any]] = []
    if path.exists():
        journal_file.read(path, poses.append)
    return poses


def _contents(folder: MissionFolder, mission: str, book: MissionBook) -> list[tuple[str, bytes]]:
    marks = marks_of(book)
    contents = [("marks.csv", _marks_table(marks)), ("events.csv", _events_table(book))]
    for sheet in sorted({book.sheet, *(on for on, _ in marks), *folder.sheets(mission)}):
        points = tuple(point for on, point in marks if on == sheet)
        contents.append((f"sheet-{sheet}.geojson", point_file.encode_points(points)))
        grid = folder.grid(mission, sheet)
        if grid is not None:
            picture = picture_of(grid)
            contents += [
                (f"sheet-{sheet}.pgm", ros_map.encode_pgm(picture)),
                (f"sheet-{sheet}.yaml", ros_map.encode_yaml(picture, f"sheet-{sheet}.pgm")),
            ]
    for _, point in marks:
        if point.thumbnail.size:
            contents.append((f"mark-{point.number}.jpg", point.thumbnail.tobytes()))
    poses = track_of(folder, mission)
    if poses:
        rows = [[pose.get(key, "") for key in "txyhs"] for pose in poses]
        contents.append(("track.csv", _table(["time", "x", "y", "heading", "sheet"], rows)))
    return contents


def picture_of(grid: LogOdds) -> OccupancyMap:
    """The map in the form of nav_msgs/OccupancyGrid."""
    values = grid.values
    cells = np.rint(100.0 / (1.0 + np.exp(-values))).astype(np.int8)
    cells[np.abs(values) < _KNOWN] = -1
    return OccupancyMap(
        cells=cells,
        resolution=grid.resolution,
        origin_x=grid.origin_x,
        origin_y=grid.origin_y,
    )


class MissionPhase(enum.StrEnum):
    """The state of a mission.

    Attributes:
        RUNS: A hub writes it now.
        INTERRUPTED: No hub writes it now; it goes on when its robot's hub starts.
        NOT_ENDED: It stopped without an end, and does not go on.
        ENDED: It was ended.
    """

    RUNS = "runs"
    INTERRUPTED = "interrupted"
    NOT_ENDED = "not ended"
    ENDED = "ended"


def _state(folder: MissionFolder, mission: str, book: MissionBook) -> MissionPhase:
    if not book.running:
        return MissionPhase.ENDED if book.ended else MissionPhase.NOT_ENDED
    if folder.running() != mission:
        return MissionPhase.NOT_ENDED
    return MissionPhase.RUNS if folder.in_use() else MissionPhase.INTERRUPTED


def mission_facts(folder: MissionFolder, mission: str) -> dict[str, Any]:
    """The entry of a mission in a list.

    Raises:
        MissionFileError: It cannot be read.
    """
    book, damaged = folder.read(mission)
    begun = book.begun
    state = _state(folder, mission, book)
    return {
        "robot": folder.robot,
        "id": mission,
        "name": book.name,
        "by": begun.by if begun else "",
        "begun": begun.stamp if begun else 0.0,
        "ended": book.ended.stamp if book.ended else None,
        "state": state.value,
        "running": state is MissionPhase.RUNS,
        "marks": len(marks_of(book)),
        "sheets": book.sheet,
        "size_bytes": folder.size(mission),
        "damaged": damaged + book.unreadable,
    }


def facts_of_marks(book: MissionBook) -> list[dict[str, Any]]:
    """The marks as JSON has them, without their pictures."""
    return [
        {
            "number": point.number,
            "sheet": sheet,
            "kind": point.kind.name.lower(),
            "x": point.x,
            "y": point.y,
            "uncertainty": _known(point.uncertainty),
            "distance": _known(point.distance),
            "stamp": point.stamp,
            "by": point.by,
            "note": point.note,
        }
        for sheet, point in marks_of(book)
    ]


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def _marks_table(marks: list[tuple[int, InterestPoint]]) -> bytes:
    rows = [
        [
            point.number, sheet, point.kind.name.lower(), point.x, point.y,
            "" if math.isnan(point.uncertainty) else point.uncertainty,
            "" if math.isnan(point.distance) else point.distance,
            moment(point.stamp), point.by, point.note,
        ]
        for sheet, point in marks
    ]  # fmt: skip
    return _table(_BY_SHEETS, rows)


def _events_table(book: MissionBook) -> bytes:
    return _table(["time", "event"], [[moment(each.stamp), each.text] for each in book.events])


def moment(stamp: float) -> str:
    """A time [s since the epoch] as the time here."""
    return time.strftime("%Y-%m-%dT%H:%M:%S%z", time.localtime(stamp))


def _table(heads: Any, rows: list[list[Any]]) -> bytes:  # noqa: ANN401 - a tuple or a list
    return "".join(map(csv_line, [heads, *rows])).encode("utf-8", "replace")
