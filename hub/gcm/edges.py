"""The message of edges: places where the ground ends and the robot would fall."""

from __future__ import annotations

from typing import Annotated

from hub.gcm.body import Metres32
from hub.gcm.geometry import Point3D
from hub.gcm.standard import Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import Sequence
from hub.values import dataclass

MOST_EDGES = 256
"""Most cells of one message; of more, some between others are left out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Edges:
    """nav_msgs/GridCells: the known edges around the robot, which assistance stops at.

    Attributes:
        header: When they were computed, and the name of their frame: `map`.
        cell_width: Size of a cell along x [m].
        cell_height: Size of a cell along y [m].
        cells: Middle of each cell.
    """

    ros_type = "nav_msgs/msg/GridCells"

    header: Header
    cell_width: Metres32
    cell_height: Metres32
    cells: Annotated[tuple[Point3D, ...], Sequence(), Most(MOST_EDGES)] = ()


EDGES = MessageDefinition(name="GCM_Edges", type=Edges, rate_hz=2.0)
"""Sent while edges are known, and once when the last one is forgotten."""

MESSAGES = (EDGES,)
