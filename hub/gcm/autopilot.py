"""Messages of a robot whose motors belong to an autopilot with modes and failsafes of its own."""

from __future__ import annotations

import enum
import math
from dataclasses import field
from typing import Annotated, Final, TypeAlias

import numpy as np

from hub.gcm.diagnostics import Severity
from hub.gcm.fields import Flag, Name, Octets, SecondsIfKnown, Sentence, ShareIfKnown, Stamp
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.ranges import Most, Range, Text
from hub.ipc.formats.wire_types import Counted, Sequence, Wire
from hub.values import dataclass

MOST_MODES: Final = 64
"""Most modes of a vehicle."""
MOST_PARAMETERS: Final = 64
"""Most parameters that are reported as unsafe."""
OPERATED_MODES: Final = frozenset(
    {
        "acro",
        "altitude",
        "altitude hold",
        "brake",
        "depth hold",
        "guided",
        "hold",
        "loiter",
        "manual",
        "position",
        "position hold",
        "stabilize",
        "stabilized",
        "steering",
        "velocity",
    }
)
"""Names of modes in which a vehicle follows sticks or velocities, or stays where it is."""

StopTime: TypeAlias = Annotated[float, Range(0.0, 1e6, unit="s", nan=True, infinite=True)]
"""Time until a vehicle stands [s]; infinite: it never stops by itself; NaN: not known."""
ParameterValue: TypeAlias = Annotated[float, Range(-1e9, 1e9, nan=True)]


class AutopilotPhase(enum.IntEnum):
    """What the hub can do with the vehicle now.

    Attributes:
        LINKING: No heartbeat came yet.
        LEARNING: It was heard; its streams and parameters are asked for.
        DISARMED: Its motors are off.
        ARMING: The operator asked to arm it, and it has not answered yet.
        DRIVING: It is armed, and in the mode that follows velocities.
        ELSEWHERE: It is armed, in a mode of its own, of a pilot or of another station. Nothing that
            moves it is sent until the operator asks for the driving mode.
        GONE: It is silent, or does not answer the hub.
    """

    LINKING = 0
    LEARNING = 1
    DISARMED = 2
    ARMING = 3
    DRIVING = 4
    ELSEWHERE = 5
    GONE = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class UnsafeParameter:
    """A parameter of the vehicle that makes it unsafe, or that was not read.

    Attributes:
        name: Its name at the vehicle.
        value: Its value; NaN: it was not read, so whether it is safe is not known.
        wanted: The value that it should have.
        why: What can happen with the present value.
    """

    name: Name
    value: ParameterValue = math.nan
    wanted: ParameterValue = math.nan
    why: Sentence = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class AutopilotState:
    """The autopilot of the robot.

    Attributes:
        stamp: Time of this report [s since the epoch]; for records only.
        phase: What the hub can do with it.
        why: Why it does not follow velocities; empty: it does.
        vehicle: What it is: "rover", "boat", "sub", "blimp", "copter"; empty: not known.
        firmware: Its program and version: "ArduPilot 4.7.0"; empty: not known.
        verified: 1: its rules were compared with recordings of such a vehicle; 0: they follow its
            documents only.
        mode: Its mode in words: "guided"; empty: not known.
        modes: The modes that the operator may ask for.
        holds: The one in which it stays where it is; empty: it has none.
        refusal: The last order that it refused, with its own reason; empty: none since the last
            order.
        armable: 1: it says that it can be armed; 0: it cannot, or does not say so.
        failsafe: 1: one of its failsafes acts; 0: none.
        heard_s: Age of its last heartbeat [s]; NaN: none came.
        round_trip_s: Time of an echo to it and back [s]; NaN: not known.
        lost: Share of the echoes of the last 10 s that did not come back; NaN: not known.
        position: 1: it knows its place; 0: it does not.
        satellites: Satellites that it sees; 255: not known.
        gain: Share of its sticks' full effect that it uses; NaN: it has no such gain.
        stops_after_zero_s: Time from a command of zero until it stands [s], at the limits of the
            robot file.
        stops_after_cut_s: The same after the link is cut [s].
        unsafe: Its unsafe parameters, and those that decide and were not read.
    """

    stamp: Stamp = 0.0
    phase: AutopilotPhase = AutopilotPhase.LINKING
    why: Sentence = ""
    vehicle: Name = ""
    firmware: Name = ""
    verified: Flag = 0
    mode: Name = ""
    modes: Annotated[tuple[str, ...], Sequence(), Most(MOST_MODES), Text(64)] = ()
    holds: Name = ""
    refusal: Sentence = ""
    armable: Flag = 0
    failsafe: Flag = 0
    heard_s: SecondsIfKnown = math.nan
    round_trip_s: SecondsIfKnown = math.nan
    lost: ShareIfKnown = math.nan
    position: Flag = 0
    satellites: Annotated[int, Range(0, 255), Wire("ubyte")] = 255
    gain: ShareIfKnown = math.nan
    stops_after_zero_s: StopTime = math.nan
    stops_after_cut_s: StopTime = math.nan
    unsafe: Annotated[
        tuple[UnsafeParameter, ...], Counted("unsafe_count"), Most(MOST_PARAMETERS)
    ] = ()


AUTOPILOT_STATE = MessageDefinition(name="GCM_Autopilot_State", type=AutopilotState, rate_hz=2.0)
"""Sent at each change too, at most ten times per second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AutopilotText:
    """A text of the autopilot, in its own words.

    Attributes:
        stamp: When it came [s since the epoch].
        level: How bad it is.
        text: The words.
    """

    stamp: Stamp = 0.0
    level: Severity = Severity.OK
    text: Sentence = ""


AUTOPILOT_TEXT = MessageDefinition(name="GCM_Autopilot_Text", type=AutopilotText, keep=Keep.ALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class MavlinkFrames:
    """Bytes of the link to the autopilot, as they were on the wire; for recordings.

    Attributes:
        stamp: When they came or left [s since the epoch].
        sent: 1: the hub sent them; 0: they came.
        data: The bytes, shape (n,): whole frames if they were sent, or came as datagrams; else a
            piece of a stream.
    """

    stamp: Stamp = 0.0
    sent: Flag = 0
    data: Octets = field(default_factory=lambda: np.zeros(0, np.uint8))


MAVLINK_FRAMES = MessageDefinition(
    name="GCM_Mavlink_Frames", type=MavlinkFrames, keep=Keep.ALL, rate_hz=50.0
)
"""Sent while it has subscribers."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MavlinkRequest:
    """Frames of another ground station for the autopilot, such as a question for its parameters.

    Attributes:
        data: Whole frames, shape (n,).
    """

    data: Octets = field(default_factory=lambda: np.zeros(0, np.uint8))


MAVLINK_REQUEST = MessageDefinition(
    name="GCM_Mavlink_Request", type=MavlinkRequest, keep=Keep.ALL, plane=Plane.COMMAND
)
"""The driver passes on what neither drives the vehicle nor keeps it alive."""

MESSAGES = (AUTOPILOT_STATE, AUTOPILOT_TEXT, MAVLINK_FRAMES, MAVLINK_REQUEST)
