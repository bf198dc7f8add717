"""The body of a robot: its name, its kind, and its footprint.

Positions are in `base_link` (ROS REP 103): x forward, y left, the origin where the robot turns.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from hub.gcm.fields import Length, Metres, Name
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import FLOAT32, Counted
from hub.values import dataclass

Metres32: TypeAlias = Annotated[Metres, FLOAT32]
MOST_CORNERS = 32
"""Most corners of a footprint."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Point32:
    """geometry_msgs/Point32.

    Attributes:
        x: Forward [m].
        y: To the left [m].
        z: Up [m].
    """

    x: Metres32
    y: Metres32
    z: Metres32 = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotBody:
    """The constants of a robot; the hub publishes them once and keeps them.

    Attributes:
        name: The robot's own name, from its robot file.
        kind: Its kind, such as "simulated-magellan".
        radius: Radius of the circle around the origin that encloses the robot [m].
        footprint: Corners of its outline on the ground, counter-clockwise, shape (n,); none:
            the circle.
    """

    name: Name
    kind: Name
    radius: Length
    footprint: Annotated[tuple[Point32, ...], Counted(), Most(MOST_CORNERS)] = ()


ROBOT_DESCRIPTION = MessageDefinition(
    name="GCM_RobotDescription",
    type=RobotBody,
)

MESSAGES = (ROBOT_DESCRIPTION,)
