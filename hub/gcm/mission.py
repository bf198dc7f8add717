"""Messages of missions: the robot's records of its findings, and their state on disk."""

from __future__ import annotations

import enum
from typing import Annotated, TypeAlias

from hub.gcm.fields import Count, Flag, Name, Number, Seconds, Sentence, Stamp
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.ranges import Range
from hub.ipc.formats.wire_types import FLOAT32, Wire
from hub.values import dataclass

Megabytes: TypeAlias = Annotated[float, Range(0.0, 1e12, unit="MB", nearest=True), FLOAT32]
MarkCount: TypeAlias = Annotated[Count, Wire("uint")]


class MissionAction(enum.IntEnum):
    """The order in a `MissionCommand`.

    Attributes:
        BEGIN: Start a mission; refused while one runs.
        NAME: Rename the running mission.
        END: End the running mission; its folder stays.
    """

    BEGIN = 0
    NAME = 1
    END = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionCommand:
    """Start, name or end a mission; answered by `CommonResult`.

    Attributes:
        action: The order.
        name: The mission's name; empty: the robot chooses one.
        by: The sender's operator, for others to read.
    """

    action: MissionAction = MissionAction.BEGIN
    name: Name = ""
    by: Name = ""


MISSION_COMMAND = MessageDefinition(
    name="GCM_Mission_Command",
    type=MissionCommand,
    plane=Plane.COMMAND,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionState:
    """The robot's mission; sent at each change, on request and once a second.

    Attributes:
        id: Name of its folder; empty: no mission since the start of mapping.
        name: The operator's name for it.
        by: The operator who started it.
        running: 1: it runs; 0: before and after.
        begun: Time of its start [s since the epoch]; 0: never.
        running_s: Time since its start [s].
        sheet: Number of the map's present sheet, from 1.
        marks: Marks on that sheet.
        earlier: Marks on the sheets before.
        unkept: Marks, changes and removals that are in memory only.
        map_age_s: Age of the map on the disk [s]; NaN: none yet.
        size_mb: Size of the mission's files [MB].
        free_mb: Free space on the disk [MB].
        fault: What is not on the disk, and the reason; empty: everything is.
        folder: The folder of this robot's missions, on the robot.
    """

    id: Name = ""
    name: Name = ""
    by: Name = ""
    running: Flag = 0
    begun: Stamp = 0.0
    running_s: Seconds = 0.0
    sheet: Number = 1
    marks: MarkCount = 0
    earlier: MarkCount = 0
    unkept: MarkCount = 0
    map_age_s: Annotated[float, Range(0.0, 1e9, unit="s", nan=True)] = float("nan")
    size_mb: Megabytes = 0.0
    free_mb: Megabytes = 0.0
    fault: Sentence = ""
    folder: Sentence = ""


MISSION_STATE = MessageDefinition(
    name="GCM_MissionState",
    type=MissionState,
    rate_hz=1.0,
)

MESSAGES = (MISSION_COMMAND, MISSION_STATE)
