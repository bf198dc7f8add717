"""Maps of ROS, whole and with their changes, as those of Rune; also turned ones."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.gcm.fields import FARTHEST_M
from hub.gcm.mapping import MOST_CELLS
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.turned_cells import turned_map
from hub.pose import Pose
from hub.ros.frame_tree import pose_of
from hub.ros.values import RosValue
from hub.values import dataclass

_LEVEL = 0.01
"""Largest tilt of a map [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RosGrid:
    """A nav_msgs/OccupancyGrid.

    Attributes:
        cells: -1 unknown, 0 free to 100 occupied; shape (height, width).
        resolution: Edge of a cell [m].
        origin: Pose of the lower left corner of cell (0, 0) in the map's frame.
    """

    cells: npt.NDArray[np.int8]
    resolution: float
    origin: Pose

    @classmethod
    def of(cls, value: RosValue) -> RosGrid:
        """The map of a message.

        Raises:
            RosMessageError: It makes no sense, or is too large.
        """
        info = value.get("info")
        width, height = int(info.get("width")), int(info.get("height"))
        cells = value.get("data")
        origin, resolution = pose_of(info.get("origin")), float(info.get("resolution"))
        sized = 0 < width <= MOST_CELLS and 0 < height <= MOST_CELLS
        if not (sized and len(cells) == width * height):
            text = f"a map of {width}x{height} cells has {len(cells)} of them, or is too large"
            raise RosMessageError(text)
        roll, pitch, yaw = origin.roll_pitch_yaw
        if not 1e-3 <= resolution <= 1e3 or max(abs(roll), abs(pitch)) > _LEVEL:
            text = "a map has no size of its cells, or is tilted"
            raise RosMessageError(text)
        x, y = np.clip(origin.origin[:2], -FARTHEST_M, FARTHEST_M).tolist()
        return cls(
            cells=np.clip(np.asarray(cells, np.int8), -1, 100).reshape(height, width),
            resolution=resolution,
            origin=Pose(x=x, y=y, theta=yaw),
        )

    def updated(self, update: RosValue) -> RosGrid:
        """The map after a map_msgs/OccupancyGridUpdate.

        Raises:
            RosMessageError: The change does not fit into it.
        """
        x, y = int(update.get("x")), int(update.get("y"))
        width, height = int(update.get("width")), int(update.get("height"))
        data = np.asarray(update.get("data"), np.int8)
        rows, columns = self.cells.shape
        inside = x >= 0 and y >= 0 and x + width <= columns and y + height <= rows
        if not inside or len(data) != width * height:
            text = f"a change of {width}x{height} cells does not fit into the map"
            raise RosMessageError(text)
        cells = self.cells.copy()
        cells[y : y + height, x : x + width] = np.clip(data, -1, 100).reshape(height, width)
        return RosGrid(cells=cells, resolution=self.resolution, origin=self.origin)

    def on_axes(self) -> OccupancyMap:
        """The map with its rows along x of its frame.

        Raises:
            RosMessageError: It is too large, turned.
        """
        made = turned_map(self.cells, self.resolution, self.origin)
        if made is None:
            height, width = self.cells.shape
            text = f"a map of {width}x{height} cells is turned, and too large for that"
            raise RosMessageError(text)
        return made
