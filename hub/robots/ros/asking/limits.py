"""How fast a robot may be driven, and how large it is, by its own parameters; pure."""

from __future__ import annotations

import math
import re
from typing import Final

from hub.errors import RobotFileError
from hub.robots.ros.asking.findings import RosFindings, number
from hub.robots.urdf import UrdfModel, urdf_model
from hub.values import dataclass

_UNKNOWN: Final = (0.3, 0.0, 1.0)
"""Limits of a robot that does not say its own: forward, sideways [m/s], turning [rad/s]."""
_MOST: Final = (1.0, 1.0, 1.5)
"""Highest limits that are written; the owner may raise them."""
_LIMITS: Final = tuple(
    re.compile(rf".*[./]{axis}[./]max_velocity")
    for axis in ("linear[./]x", "linear[./]y", "angular[./]z")
)
_SMOOTHER: Final = re.compile(r".*velocity_smoother\.max_velocity")
_RADIUS: Final = re.compile(r".*costmap[./]robot_radius")
_DESCRIPTION: Final = re.compile(r"(?:.*[./])?robot_description")
_NAME: Final = re.compile(r"<robot\b[^>]{0,500}?\bname\s*=\s*[\"']([A-Za-z][\w-]{0,31})[\"']")
_LARGEST: Final = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RosLimits:
    """How fast a robot may be driven.

    Attributes:
        linear: Forward [m/s].
        sway: Sideways [m/s]; 0: it cannot.
        angular: Turning [rad/s].
        known: Whether the robot says so itself.
    """

    linear: float
    sway: float
    angular: float
    known: bool


def limits(found: RosFindings) -> RosLimits:
    """The least of the robot's own limits, and no fast ones: its owner did not see it drive yet."""
    said: list[list[float]] = [[], [], []]
    for name, value in found.parameters.items():
        for axis, pattern in zip(said, _LIMITS, strict=True):
            if pattern.fullmatch(name):
                axis.extend(_limit(value))
        if _SMOOTHER.fullmatch(name) and isinstance(value, list | tuple) and len(value) == 3:
            for axis, each in zip(said, value, strict=True):
                axis.extend(_limit(each))
    linear, sway, angular = (
        math.floor(100.0 * min([*axis, most] if axis else [unknown]) + 1e-6) / 100.0
        for axis, unknown, most in zip(said, _UNKNOWN, _MOST, strict=True)
    )
    known = bool(said[0] and said[2])
    return RosLimits(linear=linear, sway=sway, angular=angular, known=known)


def _limit(value: object) -> list[float]:
    """A value, if it is a limit."""
    return [number(value)] if 0.01 <= number(value) <= 1e3 else []


def radius(found: RosFindings) -> float:
    """The radius of the robot for its own planner [m]; NaN: not known."""
    for name, value in found.parameters.items():
        if _RADIUS.fullmatch(name) and 0.01 < number(value) <= _LARGEST:
            return number(value)
    return math.nan


def description(found: RosFindings) -> str:
    """The text of the robot's URDF; empty: it gives none."""
    for name, value in found.parameters.items():
        if _DESCRIPTION.fullmatch(name) and isinstance(value, str) and "<robot" in value:
            return value
    for topic in found.topics_of("std_msgs/String"):
        value = found.of(topic.name).value
        if topic.name.endswith("/robot_description") and value is not None:
            text = value.field("data")
            return text if isinstance(text, str) else ""
    return ""


def model(found: RosFindings) -> tuple[UrdfModel | None, str]:
    """The robot's URDF, or None; why its outline is not known, empty: it is, or it has no URDF."""
    text = description(found)
    if not text:
        return None, ""
    try:
        made = urdf_model(text, "robot_description", found.files)
        return made, made.fault
    except RobotFileError as fault:
        return None, str(fault)


def name_of(found: RosFindings) -> str:
    """The robot's name by its URDF or its namespace; empty: not known."""
    named = _NAME.search(description(found)[:10_000])
    return named[1] if named else found.namespace.strip("/").replace("/", "-")[:32]
