"""Messages of the map: the occupancy grid, and the interest points on it."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Annotated

from hub.gcm.fields import (
    MOST_REPORTS,
    Flag,
    Length,
    LengthIfKnown,
    Metres,
    MetresIfKnown,
    Name,
    Number,
    Octets,
    Sentence,
    Stamp,
)
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import Counted

MOST_CELLS = 1 << 13
"""Longest side of a map [cells]; at 5 cm a cell it is 400 m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapRequest:
    """Ask for the map, or a window of it.

    Attributes:
        x: Middle of the window in `map` [m]; NaN: the whole map.
        y: Middle of the window in `map` [m].
        width: Extent of the window along x [m].
        height: Extent of the window along y [m].
    """

    x: MetresIfKnown = float("nan")
    y: MetresIfKnown = float("nan")
    width: Length = 10.0
    height: Length = 10.0


MAP_REQUEST = MessageDefinition(name="GCM_Map_Request", type=MapRequest)


@dataclass(frozen=True, slots=True, kw_only=True)
class Map:
    """An occupancy grid as nav_msgs/OccupancyGrid means it, coded by `hub.gcm.map_coding`.

    Attributes:
        stamp: When the newest measurement in it was made [s since the epoch].
        resolution: Edge of a cell [m].
        width_cells: Cells along x.
        height_cells: Cells along y.
        origin_x: Lower left corner of cell (0, 0) in `map` [m].
        origin_y: Lower left corner of cell (0, 0) in `map` [m].
        data: The coded cells, shape (n,); decoded: shape (height, width), row 0 at the lowest
            y; -1 unknown, 0 free to 100 occupied.
    """

    stamp: Stamp
    resolution: Annotated[float, Range(1e-3, 1e3, unit="m")]
    width_cells: Annotated[int, Range(1, MOST_CELLS)]
    height_cells: Annotated[int, Range(1, MOST_CELLS)]
    origin_x: Metres
    origin_y: Metres
    data: Octets


MAP = MessageDefinition(
    name="GCM_Common_Map",
    type=Map,
)


class PointKind(enum.IntEnum):
    """What an interest point is."""

    VICTIM = 0
    LANDMARK = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class InterestPoint:
    """Something found.

    Attributes:
        number: Unique on this robot; 0 lets the map choose one.
        kind: What it is.
        x: Where, in `map` [m].
        y: Where, in `map` [m].
        uncertainty: How far off the place may be [m]; NaN if that is not known. In a picture, the
            diagonal of the ground that the clicked pixel covers, or what map or ranges leave open;
            on the map, half the diagonal of the pixel or the cell. Rather a bound than one standard
            deviation. What is seen in a picture includes two standard deviations of the pose.
        distance: How far from the robot it was seen [m]; NaN if that is not known. When a point is
            marked, 0 says so as well, of both.
        stamp: When it was marked [s since the epoch].
        by: Who marked it.
        note: The operator's words.
        thumbnail: A small picture of it as JPEG; none if empty. Shape (n,).
        version: How often it was marked or changed, from 1. Who changes it sends the version that
            is changed; 0 for a new point.
        kept: 1 if it is on the robot's disk, 0 if it is in memory only.
        height: How high above the floor [m]; 0: on the floor, or that is not known.
    """

    number: Number = 0
    kind: PointKind
    x: Metres
    y: Metres
    uncertainty: LengthIfKnown = float("nan")
    distance: LengthIfKnown = float("nan")
    stamp: Stamp = 0.0
    by: Name = ""
    note: Sentence = ""
    thumbnail: Octets
    version: Number = 0
    kept: Flag = 0
    height: Metres = 0.0


class PointAction(enum.IntEnum):
    """What to do with an interest point.

    Attributes:
        MARK: Add it if its number is 0; else replace the one with its number and version.
        REMOVE: Remove the one with its number and version; version 0 removes any version.
    """

    MARK = 0
    REMOVE = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class PointCommand:
    """Change the interest points.

    Attributes:
        action: What to do.
        point: With what; to remove one only its number and version count.
    """

    action: PointAction = PointAction.MARK
    point: InterestPoint


POINT_COMMAND = MessageDefinition(
    name="GCM_Point_Command",
    type=PointCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class InterestPoints:
    """All interest points; when they change, on request, and every few seconds.

    Attributes:
        points: In the order of their numbers.
    """

    points: Annotated[tuple[InterestPoint, ...], Counted(), Most(MOST_REPORTS)]


INTEREST_POINTS = MessageDefinition(
    name="GCM_InterestPoints",
    type=InterestPoints,
    rate_hz=0.2,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PointRefusal:
    """A `PointCommand` was not carried out.

    Attributes:
        sender: Whose command: its number at central, as in frame headers.
        number: Number of the point that was to be changed; 0: a new one.
        text: Why, for people.
    """

    sender: Number
    number: Number
    text: Sentence


POINT_REFUSAL = MessageDefinition(name="GCM_Point_Refusal", type=PointRefusal, keep=Keep.ALL)


class MapOrder(enum.IntEnum):
    """What is to be done with the map.

    Attributes:
        SAVE: Write map and points to files.
        LOAD: Begin a new sheet with the map and the points of files.
        CLEAR: Begin a new sheet; the points are kept on it.
    """

    SAVE = 0
    LOAD = 1
    CLEAR = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MapCommand:
    """Ask mapping to do something with the whole map; answered by `CommonResult`.

    Attributes:
        order: What to do.
        name: Name of the map's files, without folder and ending; empty takes a default.
    """

    order: MapOrder = MapOrder.SAVE
    name: Name = ""


MAP_COMMAND = MessageDefinition(
    name="GCM_Map_Command",
    type=MapCommand,
    plane=Plane.COMMAND,
)

MESSAGES = (MAP_REQUEST, MAP, POINT_COMMAND, INTEREST_POINTS, POINT_REFUSAL, MAP_COMMAND)
