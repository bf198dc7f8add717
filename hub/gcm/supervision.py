"""Messages between the modules, those who want their capabilities, and the daemon."""

from __future__ import annotations

import enum
from collections.abc import Container
from dataclasses import dataclass
from typing import Annotated

from hub.gcm.capability import Capability
from hub.gcm.fields import (
    MOST_REPORTS,
    Count,
    Flag,
    Lines,
    Name,
    Names,
    Number,
    ProcessId,
    Seconds,
    Sentence,
)
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import FLOAT32, Counted


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleInfo:
    """A module says that it lives and what it can do; also its keep-alive.

    Attributes:
        name: Name at central.
        pid: Process id on its machine.
        state: "running" or "stopping".
        capabilities: Names from `hub.gcm.capability`, separated by spaces.
        needs: Capabilities of others that it needs, separated by spaces.
        errors: Exceptions its loop has logged since it started.
    """

    name: Name
    pid: ProcessId
    state: Name
    capabilities: Names
    needs: Names = ""
    errors: Number = 0


MODULE_INFO = MessageDefinition(
    name="GCM_ModuleInfo",
    type=ModuleInfo,
    rate_hz=1.0,
)

KEEP_ALIVE_S = 5.0
DRIVER_KEEP_ALIVE_S = 1.0
"""Silence after which a module counts as hanging, and one that moves the wheels [s]."""
_ANNOUNCEMENTS = 4
"""So many a module makes in that time, so that one that comes late does no harm."""


def keep_alive_s(capabilities: Container[str]) -> float:
    """Silence after which a module with these capabilities counts as hanging [s]."""
    return DRIVER_KEEP_ALIVE_S if Capability.DRV_BASE in capabilities else KEEP_ALIVE_S


def announce_every_s(capabilities: Container[str]) -> float:
    """How often a module with these capabilities announces itself: the time between two [s]."""
    return min(1.0 / MODULE_INFO.rate_hz, keep_alive_s(capabilities) / _ANNOUNCEMENTS)


class ModulePhase(enum.IntEnum):
    """What the daemon does with a module.

    Attributes:
        STOPPED: It does not run, as nobody wants it or somebody stopped it.
        STARTING: Its process runs, and has not announced itself yet.
        RUNNING: It announces itself.
        STOPPING: It was asked to end.
        WAITING: It ended by itself; it is started again after a pause.
        FAILED: It ended too often and is given up until somebody starts it.
    """

    STOPPED = 0
    STARTING = 1
    RUNNING = 2
    STOPPING = 3
    WAITING = 4
    FAILED = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleReport:
    """What the daemon knows of one module.

    Attributes:
        name: Its name.
        phase: What the daemon does with it.
        pid: Process id; 0 while it does not run.
        capabilities: What it can do, separated by spaces; it said so itself if `asked` is 1.
        needs: What it needs of others, separated by spaces.
        asked: 1 if it answered with its real capabilities, 0 if these are the robot file's hint.
        always: 1 if it is to run always, 0 if on demand.
        starts: How often it was started.
        processor: Part of one processor that it takes; NaN when not known.
        memory_mb: Resident memory [MB]; NaN when not known.
        age_s: Time since it was started [s]; 0 while it does not run.
        why: Why it is in this phase, for people, after its name; empty where it simply runs.
    """

    name: Name
    phase: ModulePhase
    pid: ProcessId
    capabilities: Names
    needs: Names
    asked: Flag
    always: Flag
    starts: Annotated[int, Range(0, 0x7FFF_FFFF)]
    processor: Annotated[float, Range(0.0, 1e4, nan=True), FLOAT32]
    memory_mb: Annotated[float, Range(0.0, 1e9, unit="MB", nan=True), FLOAT32]
    age_s: Annotated[Seconds, FLOAT32]
    why: Sentence


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleReports:
    """What the daemon knows of all modules; when it changes, on request, and each second.

    Attributes:
        robot: Name of the robot.
        modules: One each, in the order of the robot file.
    """

    robot: Name
    modules: Annotated[tuple[ModuleReport, ...], Counted(), Most(MOST_REPORTS)]


MODULE_REPORTS = MessageDefinition(
    name="GCM_Variable_ModuleInfo",
    type=ModuleReports,
    rate_hz=1.0,
)


class CapabilityPhase(enum.IntEnum):
    """What can be expected of a capability.

    Attributes:
        AVAILABLE: A module could be started that has it.
        STARTING: A module that has it is being started.
        RUNNING: A module that has it runs.
        UNAVAILABLE: Modules have it, and none of them can be started.
    """

    AVAILABLE = 0
    STARTING = 1
    RUNNING = 2
    UNAVAILABLE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class CapabilityReport:
    """One capability of the robot.

    Attributes:
        name: From `hub.gcm.capability`, or a module's own.
        phase: What can be expected of it.
        module: The module that provides it, or would; empty if none can.
        modules: All modules that have it, separated by spaces.
        wanted_by: Who wants it, separated by spaces.
    """

    name: Name
    phase: CapabilityPhase
    module: Name
    modules: Names
    wanted_by: Names


@dataclass(frozen=True, slots=True, kw_only=True)
class CapabilityReports:
    """What the robot can do; when it changes, on request, and each second.

    Attributes:
        robot: Name of the robot.
        capabilities: One each, in alphabetical order.
        undeclared: Number of modules that have not said yet what they can do.
    """

    robot: Name
    capabilities: Annotated[tuple[CapabilityReport, ...], Counted(), Most(MOST_REPORTS)]
    undeclared: Count = 0


CAPABILITY_REPORTS = MessageDefinition(
    name="GCM_Common_Capabilities",
    type=CapabilityReports,
    rate_hz=1.0,
)


LEASE_S = 3.0
"""Time after which a want that is not repeated is given up, unless it says another [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CapabilityWants:
    """What a console or module wants to be available: its keep-alive, which it repeats.

    Attributes:
        holder: Who wants it; the name at central.
        capabilities: All it wants, separated by spaces; empty gives up the others.
        lease_s: How long it holds unless it is repeated [s].
    """

    holder: Name
    capabilities: Names
    lease_s: Annotated[float, Range(0.0, 86_400.0, unit="s")] = LEASE_S


CAPABILITY_WANTS = MessageDefinition(
    name="GCM_Capability_Wants",
    type=CapabilityWants,
    plane=Plane.COMMAND,
    rate_hz=1.0,
    lifespan_s=LEASE_S,
)


class ModuleOrder(enum.IntEnum):
    """What is to be done with a module."""

    START = 0
    STOP = 1
    RESTART = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleCommand:
    """Ask the daemon to do something with a module; answered by `CommonResult`.

    Attributes:
        module: Its name.
        order: What to do.
    """

    module: Name = ""
    order: ModuleOrder = ModuleOrder.START


MODULE_COMMAND = MessageDefinition(
    name="GCM_Module_Command",
    type=ModuleCommand,
    plane=Plane.COMMAND,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LogRequest:
    """Ask the daemon for what a module has written to its outputs.

    Attributes:
        module: Its name.
        first: Number of the first line wanted, from 1; 0: the last `most` lines.
        most: How many lines at most.
    """

    module: Name = ""
    first: Number = 0
    most: Annotated[int, Range(0, 0x7FFF_FFFF)] = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class LogLines:
    """Lines that a module has written; the daemon remembers the last thousand.

    Attributes:
        first: Number of the first of them; higher than asked for where older ones are forgotten.
        next: Number of the line after the last of them.
        text: The lines, each with its end.
    """

    first: Number
    next: Number
    text: Lines


LOG_REQUEST = MessageDefinition(name="GCM_Log_Request", type=LogRequest)
LOG_LINES = MessageDefinition(name="GCM_Log", type=LogLines)

MESSAGES = (
    MODULE_INFO,
    MODULE_REPORTS,
    CAPABILITY_REPORTS,
    CAPABILITY_WANTS,
    MODULE_COMMAND,
    LOG_REQUEST,
    LOG_LINES,
)
