"""Messages of missions: what the robot keeps of what was found, and whether it is kept."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Annotated, TypeAlias

from hub.gcm.fields import Count, Flag, Name, Number, Seconds, Sentence, Stamp
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.ranges import Range
from hub.ipc.formats.wire_types import FLOAT32, Wire

Megabytes: TypeAlias = Annotated[float, Range(0.0, 1e12, unit="MB", nearest=True), FLOAT32]
MarkCount: TypeAlias = Annotated[Count, Wire("uint")]


class MissionAction(enum.IntEnum):
    """What a `MissionCommand` asks for.

    Attributes:
        BEGIN: A new mission; while one runs, this is refused.
        NAME: Another name for the mission that runs.
        END: The end of the mission that runs; its folder stays.
    """

    BEGIN = 0
    NAME = 1
    END = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionCommand:
    """Begin, name or end a mission; answered by `CommonResult`.

    Attributes:
        action: What to do.
        name: The mission's name; empty: the robot chooses one.
        by: Who wants it, for others to read.
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
    """The robot's mission; when it changes, on request and once a second.

    Attributes:
        id: Name of its folder; empty: there was none since mapping started.
        name: What the operator calls it.
        by: Who began it.
        running: 1 while it runs; 0 before and after.
        begun: When it was begun [s since the epoch]; 0: never.
        running_s: How long ago that was [s].
        sheet: Number of the sheet of the map that is in use, from 1.
        marks: Marks on that sheet.
        earlier: Marks on the sheets before.
        unkept: Marks, changes and removals that are in memory only.
        map_age_s: How old what the disk has of the map is [s]; NaN: it has none yet.
        size_mb: Files of the mission [MB].
        free_mb: What the disk has left [MB].
        fault: What is not kept, and why; empty: all is.
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
