"""What is wrong with a robot now, in plain sentences: diagnostic_msgs of ROS 2, field for field.

Each publisher sends all its present problems, at each change and once per second. A problem that
ended is missing in the next message. Receivers keep the newest message of each publisher.
"""

from __future__ import annotations

import enum
from typing import Annotated, Final

from hub.gcm.fields import Name, Sentence
from hub.gcm.standard import Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most, Text
from hub.ipc.formats.wire_types import Sequence, Wire
from hub.values import dataclass

MOST_PROBLEMS: Final = 256
"""Most entries of one message."""
MOST_VALUES: Final = 64
"""Most values of one entry."""


class Severity(enum.IntEnum):
    """How bad it is.

    Attributes:
        OK: All is well.
        WARN: The operator should know it.
        ERROR: The operator must act.
        STALE: The part is silent, so its state is not known.
    """

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyValue:
    """diagnostic_msgs/KeyValue.

    Attributes:
        key: Name of the value.
        value: The value as text.
    """

    ros_type = "diagnostic_msgs/msg/KeyValue"

    key: Name
    value: Annotated[str, Text(200)]


SLEEP = "sleep"
"""Name of the problem that the robot's computer slept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DiagnosticStatus:
    """diagnostic_msgs/DiagnosticStatus.

    Attributes:
        level: How bad it is.
        name: Name of the cause, the same as long as it lasts: "tipped", "stuck", "slip", "leak",
            "tether", "battery", "hold depth", "tilt", "edge", "range sonar", "sleep".
        message: A sentence for the operator: "tipped over: roll 87 deg".
        hardware_id: The part of the robot; empty: the whole robot.
        values: Further values, for tools.
    """

    ros_type = "diagnostic_msgs/msg/DiagnosticStatus"

    level: Annotated[Severity, Wire("char")]
    name: Name
    message: Sentence
    hardware_id: Name = ""
    values: Annotated[tuple[KeyValue, ...], Sequence(), Most(MOST_VALUES)] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostics:
    """diagnostic_msgs/DiagnosticArray: all present problems of one publisher.

    Attributes:
        header: When they were found.
        status: The problems; none: all is well.
    """

    ros_type = "diagnostic_msgs/msg/DiagnosticArray"

    header: Header = Header()
    status: Annotated[tuple[DiagnosticStatus, ...], Sequence(), Most(MOST_PROBLEMS)] = ()


DIAGNOSTICS = MessageDefinition(name="GCM_Diagnostics", type=Diagnostics, rate_hz=1.0)

MESSAGES = (DIAGNOSTICS,)
