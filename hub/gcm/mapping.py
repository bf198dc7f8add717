"""Messages of the map: the occupancy grid, and the interest points on it."""

from __future__ import annotations

import enum
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
from hub.values import dataclass

MOST_CELLS = 1 << 13
"""Longest side of a map [cells]; at 5 cm a cell it is 400 m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapRequest:
    """Ask for the map, or a window of it.

    Attributes:
        x: Centre of the window in `map` [m]; NaN: the whole map.
        y: Centre of the window in `map` [m].
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
    """An occupancy grid like nav_msgs/OccupancyGrid, coded by `hub.gcm.map_coding`.

    Attributes:
        stamp: Time of its newest measurement [s since the epoch].
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
    """The kind of an interest point."""

    VICTIM = 0
    LANDMARK = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class InterestPoint:
    """A marked point on the map.

    Attributes:
        number: Unique on this robot; 0: the map chooses one.
        kind: Its kind.
        x: Position in `map` [m].
        y: Position in `map` [m].
        uncertainty: Bound of the position's error [m]; NaN: not known. In a picture: the diagonal
            of the ground in the clicked pixel, or the error of map or ranges, and two standard
            deviations of the pose. On the map: half the diagonal of the pixel or the cell.
        distance: Distance from the robot when it was seen [m]; NaN: not known. In a new point,
            0 means "not known" too, for distance and uncertainty.
        stamp: Time of marking [s since the epoch].
        by: The operator who marked it.
        note: The operator's words.
        thumbnail: A small picture of it as JPEG, shape (n,); empty: none.
        version: Counts its marks and changes, from 1. A change carries the version that it
            replaces; 0: a new point.
        kept: 1: it is on the robot's disk; 0: in memory only.
        height: Height above the floor [m]; 0: on the floor, or not known.
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
    """An order about an interest point.

    Attributes:
        MARK: Add it if its number is 0; else replace the point with its number and version.
        REMOVE: Remove the point with its number and version; version 0: any version.
    """

    MARK = 0
    REMOVE = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class PointCommand:
    """Change the interest points.

    Attributes:
        action: The order.
        point: The point; REMOVE uses only its number and version.
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
    """All interest points; sent at each change, on request, and every few seconds.

    Attributes:
        points: By number.
    """

    points: Annotated[tuple[InterestPoint, ...], Counted(), Most(MOST_REPORTS)]


INTEREST_POINTS = MessageDefinition(
    name="GCM_InterestPoints",
    type=InterestPoints,
    rate_hz=0.2,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PointRefusal:
    """The refusal of a `PointCommand`.

    Attributes:
        sender: Number at central of the command's sender, as in frame headers.
        number: Number of the point to change; 0: a new one.
        text: The reason, for people.
    """

    sender: Number
    number: Number
    text: Sentence


POINT_REFUSAL = MessageDefinition(name="GCM_Point_Refusal", type=PointRefusal, keep=Keep.ALL)


class MapOrder(enum.IntEnum):
    """An order about the map.

    Attributes:
        SAVE: Write map and points to files.
        LOAD: Start a new sheet with the map and the points of files.
        CLEAR: Start a new sheet; it keeps the points.
    """

    SAVE = 0
    LOAD = 1
    CLEAR = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MapCommand:
    """An order to mapping about the whole map; answered by `CommonResult`.

    Attributes:
        order: The order.
        name: Name of the map's files, without folder and ending; empty: a default.
    """

    order: MapOrder = MapOrder.SAVE
    name: Name = ""


MAP_COMMAND = MessageDefinition(
    name="GCM_Map_Command",
    type=MapCommand,
    plane=Plane.COMMAND,
)

MESSAGES = (MAP_REQUEST, MAP, POINT_COMMAND, INTEREST_POINTS, POINT_REFUSAL, MAP_COMMAND)
