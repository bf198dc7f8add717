"""Messages between modules, consoles and the daemon about modules and capabilities."""

from __future__ import annotations

import enum
from collections.abc import Container
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
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleInfo:
    """The announcement of a module: its keep-alive, with its capabilities.

    Attributes:
        name: Name at central.
        pid: Process id on its machine.
        state: "running" or "stopping".
        capabilities: Names from `hub.gcm.capability`, separated by spaces.
        needs: Capabilities of others that it needs, separated by spaces.
        errors: Exceptions that its loop has logged since its start.
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
"""Silence after which a module counts as hanging, in general and for the driver [s]."""
_ANNOUNCEMENTS = 4
"""Number of announcements in that time: a late one does no harm."""


def keep_alive_s(capabilities: Container[str]) -> float:
    """Silence after which a module with these capabilities counts as hanging [s]."""
    return DRIVER_KEEP_ALIVE_S if Capability.DRV_BASE in capabilities else KEEP_ALIVE_S


def announce_every_s(capabilities: Container[str]) -> float:
    """Time between two announcements of a module with these capabilities [s]."""
    return min(1.0 / MODULE_INFO.rate_hz, keep_alive_s(capabilities) / _ANNOUNCEMENTS)


def is_console(capabilities: Container[str]) -> bool:
    """Whether a client with these capabilities is a console: a visitor, no module of the robot."""
    return Capability.CON_REAL in capabilities


class ModulePhase(enum.IntEnum):
    """The phase of a module at the daemon.

    Attributes:
        STOPPED: It does not run: it is not wanted, or an order stopped it.
        STARTING: Its process runs, and has not announced itself yet.
        RUNNING: It announces itself.
        STOPPING: It has the order to end.
        WAITING: It ended by itself; the daemon restarts it after a pause.
        FAILED: It ended too often; only an order starts it again.
    """

    STOPPED = 0
    STARTING = 1
    RUNNING = 2
    STOPPING = 3
    WAITING = 4
    FAILED = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleReport:
    """The daemon's report on one module.

    Attributes:
        name: Its name.
        phase: Its phase.
        pid: Process id; 0: it does not run.
        capabilities: Its capabilities, separated by spaces.
        needs: The capabilities it needs, separated by spaces.
        asked: 1: the module itself reported its capabilities; 0: they are the robot file's hint.
        always: 1: it runs always; 0: on demand.
        starts: Number of its starts.
        processor: Part of one processor that it uses; NaN: not known.
        memory_mb: Resident memory [MB]; NaN: not known.
        age_s: Time since its start [s]; 0: it does not run.
        why: The reason for its phase, for people, after its name; empty: it simply runs.
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
    """The daemon's report on all modules; sent at each change, on request, and each second.

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
    """The state of a capability.

    Attributes:
        AVAILABLE: A module with it could start.
        STARTING: A module with it is starting.
        RUNNING: A module with it runs.
        UNAVAILABLE: No module with it can start.
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
        phase: Its state.
        module: The module that provides it, or would; empty: none can.
        modules: All modules that have it, separated by spaces.
        wanted_by: The holders that want it, separated by spaces.
    """

    name: Name
    phase: CapabilityPhase
    module: Name
    modules: Names
    wanted_by: Names


@dataclass(frozen=True, slots=True, kw_only=True)
class CapabilityReports:
    """The robot's capabilities; sent at each change, on request, and each second.

    Attributes:
        robot: Name of the robot.
        capabilities: One each, in alphabetical order.
        undeclared: Number of modules without a report of their capabilities.
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
"""Default time after which a want ends unless it is repeated [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CapabilityWants:
    """The wanted capabilities of a console or module, which it repeats.

    Attributes:
        holder: Name of the holder at central.
        capabilities: All its wanted capabilities, separated by spaces; empty: none any more.
        lease_s: Time after which the want ends unless it is repeated [s].
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
    """An order about a module."""

    START = 0
    STOP = 1
    RESTART = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleCommand:
    """An order to the daemon about a module; answered by `CommonResult`.

    Attributes:
        module: Its name.
        order: The order.
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
    """Ask the daemon for the output of a module.

    Attributes:
        module: Its name.
        first: Number of the first line, from 1; 0: the last `most` lines.
        most: Most lines.
    """

    module: Name = ""
    first: Number = 0
    most: Annotated[int, Range(0, 0x7FFF_FFFF)] = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class LogLines:
    """Lines of a module's output; the daemon keeps the last thousand.

    Attributes:
        first: Number of the first line; higher than requested if older ones are dropped.
        next: Number of the line after the last.
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
