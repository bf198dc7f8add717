"""Where a robot with ROS is: by its odometry, else by its frames; in its own map, if it has one.

| topic of odometry | what counts |
| --- | --- |
| something publishes it | it |
| nothing publishes it for 2 s after a connection, or the robot file names none | the frames |

With a map of its own the place is in the frame of that map as soon as the frames say where it is;
for the first 2 s of a connection without them it is not known.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final

from hub.gcm.fields import FARTHEST_M
from hub.paths import for_reckoning
from hub.pose import Pose
from hub.robots.description import RobotDescription
from hub.robots.ros.frames import STATIC_FRAMES, RosFrames
from hub.robots.ros.line import RosLine, RosMessage
from hub.robots.ros.odometry import RosOdometry, RosPlace, place_of_odometry
from hub.robots.ros.reckoning_file import ReckoningFile
from hub.robots.ros.topic_reader import TopicReader
from hub.ros.clock_delay import ClockDelay
from hub.ros.values import RosValue

PATIENCE_S: Final = 2.0
"""Time for the robot's topics to become known after a connection [s]."""
_IN_MAP: Final = 0x5A5A_5A5A
"""Makes another number of a dead reckoning: its places in the map."""


class RosWhereabouts:
    """The places of one robot.

    Attributes:
        odometry: Its dead reckoning.
    """

    def __init__(self, robot: RobotDescription, line: RosLine, reader: TopicReader) -> None:
        """Subscribe to the odometry."""
        self._table, self._line, self._reader = robot.ros, line, reader
        self._file = ReckoningFile(for_reckoning(f"{robot.name} {robot.ros.identity}"))
        speed = max(robot.linear_limit, robot.sway_limit)
        self.odometry = RosOdometry(speed, robot.angular_limit, self._file.read())
        self._frames: RosFrames | None = None
        self._by_odometry = False
        self._up_since = math.inf
        self._delay = ClockDelay()
        reader.read(self._table.odom, self._placed)
        if self._table.map or not self._table.odom:
            self._use_frames()

    def advance(self, now: float) -> None:
        """Choose what counts, and save the place [s, monotonic]."""
        self._file.save(self.odometry.kept, now)
        if not self._line.state.up:
            self._up_since = math.inf
        elif self._up_since == math.inf:
            self._up_since = now
        elif (
            self._frames is None
            and now - self._up_since > PATIENCE_S
            and self._table.odom not in self._line.graph.topics
        ):
            self._use_frames()

    def known(self, now: float) -> RosPlace | None:
        """Where the robot is; None: that is not known at a time [s, monotonic]."""
        place, in_map = self.odometry.place, self._odom_in_map
        if place is None or not self.odometry.fresh(now):
            return None
        if in_map is None:
            # A driver that begins waits for the frames: else the place would seem to be lost.
            return None if self._table.map and now - self._up_since < PATIENCE_S else place
        pose = in_map.then(place.pose)
        near = max(abs(pose.x), abs(pose.y)) <= FARTHEST_M
        return dataclasses.replace(place, pose=pose) if near else None

    @property
    def frame(self) -> str:
        """Name of the robot's frame in which `known` places are."""
        return self._table.odom_frame if self._odom_in_map is None else self._table.map_frame

    @property
    def number(self) -> int:
        """Number of the dead reckoning; 0: there is none yet."""
        number = self.odometry.number
        return number if self._odom_in_map is None else (number ^ _IN_MAP) or 1

    def lacks_map(self, now: float) -> bool:
        """Whether its frames do not say where its own map is, although they should by now."""
        late = now - self._up_since >= PATIENCE_S
        return bool(self._table.map) and late and self._odom_in_map is None

    @property
    def source(self) -> str:
        """The topic that says where the robot is."""
        return self._table.tf if self._frames and not self._by_odometry else self._table.odom

    @property
    def _odom_in_map(self) -> Pose | None:
        if self._frames is None or not self._table.map:
            return None
        return self._frames.odom_in_map

    def _use_frames(self) -> None:
        self._frames = RosFrames(self._table)
        self._reader.read(self._table.tf, self._framed, each=True)
        self._reader.read(STATIC_FRAMES, self._framed, each=True)

    def _placed(self, value: RosValue, message: RosMessage) -> None:
        self._by_odometry = True
        self._take(place_of_odometry(value, message.measured), message)

    def _framed(self, value: RosValue, message: RosMessage) -> None:
        frames = self._frames
        moved = frames is not None and frames.take(value, message.measured)
        if frames is not None and frames.place is not None and moved and not self._by_odometry:
            self._take(frames.place, message)

    def _take(self, place: RosPlace, message: RosMessage) -> None:
        """Take a place; what it waited in the robot, before its middleware, is part of its age."""
        waited = 0.0
        if message.time_ns and place.stamp > 0.0:
            stamp = round(place.stamp * 1e9)
            waited = self._delay.of(stamp, message.time_ns, message.arrived)
        late = message.arrived - message.measured + waited
        place = dataclasses.replace(place, measured=place.measured - waited)
        self.odometry.take(place, self._line.state.connections, late)
