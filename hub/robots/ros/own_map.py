"""The map that a robot with ROS makes itself, for the mapping module; by a line of its own."""

from __future__ import annotations

from hub.gcm.mapping import MOST_CELLS
from hub.gcm.occupancy_map import OccupancyMap
from hub.robots.ros.frames import STATIC_FRAMES, RosFrames
from hub.robots.ros.line import RosLine, RosMessage
from hub.robots.ros.topic_reader import TopicReader
from hub.robots.ros_table import RosTable
from hub.ros.occupancy import RosGrid
from hub.ros.values import RosValue

_UPDATES = "_updates"
"""What ROS adds to the name of a map for the topic of its changes."""
_MOST_MAP = MOST_CELLS**2 + 1024
"""Longest message of a map [bytes]."""


class RosMap:
    """Implements `OwnMap`: an OccupancyGrid with its changes.

    It counts as soon as the robot's frames say where its map is: until then the driver gives places
    in another frame.
    """

    def __init__(self, line: RosLine, table: RosTable) -> None:
        """Subscribe.

        Args:
            line: A line that nothing else uses.
            table: The robot file's.
        """
        self._line = line
        self._frames = RosFrames(table)
        self._grid: RosGrid | None = None
        self._map: OccupancyMap | None = None
        self._is_new = False
        self._reader = TopicReader(line)
        self._topics: tuple[str, ...] = (table.tf, STATIC_FRAMES)
        for topic in self._topics:
            self._reader.read(topic, self._framed, each=True)
        for topic, take in ((table.map, self._mapped), (f"{table.map}{_UPDATES}", self._updated)):
            self._reader.read(topic, take, each=True, most=_MOST_MAP)

    def advance(self, now: float) -> None:
        """Read the line [s, monotonic]."""
        self._line.advance(now)

    def take(self) -> OccupancyMap | None:
        """The map, if it changed since the last call and its place is known."""
        if not self._is_new or self._frames.odom_in_map is None:
            return None
        for topic in self._topics:  # where it is now, the driver knows
            self._reader.stop(topic)
        self._topics = ()
        self._is_new = False
        return self._map

    @property
    def fault(self) -> str:
        """Why there is no map, or no newer one; empty: all is well."""
        if self._line.state.up and self._map is not None and self._frames.odom_in_map is None:
            return "the robot's own map is not used: no frames join it with the odometry"
        return "; ".join(f"{topic}: {why}" for topic, why in self._reader.faults.items())

    def close(self) -> None:
        """Leave the line."""
        self._line.close()

    def _framed(self, value: RosValue, message: RosMessage) -> None:
        self._frames.take(value, message.measured)

    def _mapped(self, value: RosValue, _: RosMessage) -> None:
        self._renew(RosGrid.of(value))

    def _updated(self, value: RosValue, _: RosMessage) -> None:
        if self._grid is not None:
            self._renew(self._grid.updated(value))

    def _renew(self, grid: RosGrid) -> None:
        self._grid, self._map, self._is_new = grid, grid.on_axes(), True
