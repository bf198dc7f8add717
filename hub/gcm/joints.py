"""The message of joints that the body moves, such as flippers: sensor_msgs/JointState of ROS 2."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated

import numpy as np
import numpy.typing as npt

from hub.gcm.body import MOST_PARTS
from hub.gcm.fields import Name
from hub.gcm.standard import Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most, Range, Text
from hub.ipc.formats.wire_types import Sequence
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class JointState:
    """One joint now.

    Attributes:
        name: As in the description.
        position: Its angle [rad]; NaN: not known.
        velocity: Its turn rate [rad/s]; NaN: not known.
        effort: Its moment [N m]; NaN: not known.
    """

    name: Name
    position: float = math.nan
    velocity: float = math.nan
    effort: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointStates:
    """sensor_msgs/JointState: all joints, in the order of the description.

    Attributes:
        header: When they were measured.
        name: Their names.
        position: Their angles [rad], shape (n,); NaN: not known.
        velocity: Their turn rates [rad/s], shape (n,); NaN: not known.
        effort: Their moments [N m], shape (n,); NaN: not known.
    """

    ros_type = "sensor_msgs/msg/JointState"

    header: Header = Header()
    name: Annotated[tuple[str, ...], Sequence(), Most(MOST_PARTS), Text(64)] = ()
    position: Annotated[
        npt.NDArray[np.float64],
        Sequence(),
        Most(MOST_PARTS),
        Range(-100.0, 100.0, unit="rad", nan=True),
    ]
    velocity: Annotated[
        npt.NDArray[np.float64],
        Sequence(),
        Most(MOST_PARTS),
        Range(-100.0, 100.0, unit="rad/s", nan=True),
    ]
    effort: Annotated[
        npt.NDArray[np.float64],
        Sequence(),
        Most(MOST_PARTS),
        Range(-1e6, 1e6, unit="N m", nan=True),
    ]

    @classmethod
    def of(cls, joints: Iterable[JointState], header: Header) -> JointStates:
        """The message of joints that were measured at the same time."""
        each = tuple(joints)
        return cls(
            header=header,
            name=tuple(joint.name for joint in each),
            position=np.array([joint.position for joint in each]),
            velocity=np.array([joint.velocity for joint in each]),
            effort=np.array([joint.effort for joint in each]),
        )

    def position_of(self, name: str) -> float:
        """The angle of a joint [rad]; NaN: not known."""
        at = self.name.index(name) if name in self.name else len(self.position)
        return float(self.position[at]) if at < len(self.position) else math.nan


JOINT_STATES = MessageDefinition(name="GCM_JointStates", type=JointStates, rate_hz=10.0)
"""10 Hz while a joint moves, else once per second."""

MESSAGES = (JOINT_STATES,)
