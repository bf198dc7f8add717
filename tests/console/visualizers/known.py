"""What a robot may tell beside its own state, made for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from hub.gcm.autonomy import AUTONOMY_STATE, AutonomyState, Behaviour, DrivingMode, Phase
from hub.gcm.flight import ALTITUDE, Altitude
from hub.gcm.imu import IMU, Imu
from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints, PointKind
from hub.gcm.supervision import (
    CAPABILITY_REPORTS,
    MODULE_REPORTS,
    CapabilityPhase,
    CapabilityReport,
    CapabilityReports,
    ModulePhase,
    ModuleReport,
    ModuleReports,
)
from hub.ipc.definition import MessageDefinition

NO_PICTURE = np.zeros(0, np.uint8)


def point(number: int, kind: PointKind = PointKind.VICTIM, **changes: Any) -> InterestPoint:
    """A mark at (2.3, -1.1) without a note."""
    values: dict[str, Any] = {"x": 2.3, "y": -1.1, "by": "anna", "thumbnail": NO_PICTURE, "kept": 1}
    return InterestPoint(number=number, kind=kind, **values | changes)


def points(*marks: InterestPoint) -> InterestPoints:
    """All marks."""
    return InterestPoints(points=marks)


def module(name: str, phase: ModulePhase = ModulePhase.RUNNING, **changes: Any) -> ModuleReport:
    """A module that has run for a minute."""
    values: dict[str, Any] = {
        "pid": 7,
        "capabilities": "",
        "needs": "",
        "asked": 1,
        "always": 0,
        "starts": 1,
        "processor": 0.034,
        "memory_mb": 41.6,
        "age_s": 60.0,
        "why": "wanted by rune",
    }
    return ModuleReport(name=name, phase=phase, **values | changes)


def modules(*reports: ModuleReport) -> ModuleReports:
    """All modules."""
    return ModuleReports(robot="magellan", modules=reports)


def capability(
    name: str, phase: CapabilityPhase = CapabilityPhase.RUNNING, module: str = "", wanted: str = ""
) -> CapabilityReport:
    """A capability of one module."""
    return CapabilityReport(name=name, phase=phase, module=module, modules=module, wanted_by=wanted)


def capabilities(*reports: CapabilityReport) -> CapabilityReports:
    """All capabilities."""
    return CapabilityReports(robot="magellan", capabilities=reports)


def autonomy(**changes: Any) -> AutonomyState:
    """A robot that explores and has explored 42 percent."""
    values: dict[str, Any] = {
        "behaviour": Behaviour.EXPLORE,
        "asked": Behaviour.EXPLORE,
        "pilot": DrivingMode.AUTONOMY,
        "phase": Phase.ACTIVE,
        "why": "explores: a frontier of 2.1 m, 4.7 m away",
        "x": 3.1,
        "y": -0.5,
        "frontier_m": 12.3,
        "explored": 0.42,
        "distance_m": 4.7,
        "seconds": 151.0,
        "sender": 5,
        "number": 1,
    }
    return AutonomyState(**values | changes)


def everything() -> dict[MessageDefinition[Any], Any]:
    """Something of each kind."""
    return {
        IMU: Imu.of(roll=0.3, pitch=-0.1),
        AUTONOMY_STATE: autonomy(),
        ALTITUDE: Altitude(stamp=0.0, depth=3.3, climb=-0.2),
        INTEREST_POINTS: points(point(1, note="under the table"), point(2, PointKind.LANDMARK)),
        MODULE_REPORTS: modules(
            module("driver"),
            module("vision", ModulePhase.FAILED, why="it ended 5 times within a minute"),
        ),
        CAPABILITY_REPORTS: capabilities(
            capability("NAV_MOVE", module="navigation", wanted="rune"),
            capability("VIS_VID", CapabilityPhase.UNAVAILABLE),
        ),
    }
