"""The tables of a robot file for holds, lights and joints."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Any, TypeVar

from hub import toml_reader as toml
from hub.gcm.body import HoldBody, HoldKind, JointBody, LightBody
from hub.robots.body_tables import CameraTable, read_each
from hub.robots.ros_table import ros_name
from hub.toml_reader import choice, degrees, key, number, text
from hub.values import dataclass

Table = TypeVar("Table")

VEHICLE = ("hold", "light", "joint")
"""The names of these tables."""
_NAME = text(32)


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldTable:
    """A `[[hold]]`: what the body keeps by itself while no motion is commanded."""

    kind: HoldKind = key(
        choice({each.name.lower(): each for each in HoldKind}), meaning="what it keeps"
    )
    tolerance: float = key(
        number(0.01, 100.0), 0.3, "the hold fails when the robot is farther off [m]"
    )
    tolerance_angle: float = key(
        degrees(0.1, 180.0),
        math.radians(20.0),
        "the same for a heading [degrees]",
        at="tolerance_deg",
        without="20",
    )

    @property
    def name(self) -> str:
        """Its kind, which no other hold of the robot has."""
        return self.kind.name.lower()

    @property
    def hold(self) -> HoldBody:
        """What the hub publishes of it."""
        heading = self.kind is HoldKind.HEADING
        tolerance = self.tolerance_angle if heading else self.tolerance
        return HoldBody(kind=self.kind, tolerance=tolerance)


@dataclass(frozen=True, slots=True, kw_only=True)
class LightTable:
    """A `[[light]]`: a light that the driver switches."""

    name: str = key(_NAME, meaning="its name")
    topic: str = key(ros_name, "", "of a robot with ROS: its topic of std_msgs, or SetBool service")

    @property
    def light(self) -> LightBody:
        """What the hub publishes of it."""
        return LightBody(name=self.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class JointTable:
    """A `[[joint]]`: a joint that the operator moves, besides the heads of cameras."""

    name: str = key(_NAME, meaning="its name")
    lowest: float = key(degrees(-360.0, 360.0), meaning="least angle [degrees]", at="lowest_deg")
    highest: float = key(
        degrees(-360.0, 360.0), meaning="largest angle [degrees]", at="highest_deg"
    )
    speed: float = key(
        degrees(0.1, 3600.0),
        math.radians(45.0),
        "largest turn rate [degrees/s]",
        at="speed_deg",
        without="45",
    )
    topic: str = key(ros_name, "", "of a robot with ROS: topic of its angle, a Float64")

    @property
    def joint(self) -> JointBody:
        """What the hub publishes of it."""
        return JointBody(name=self.name, lowest=self.lowest, highest=self.highest, speed=self.speed)


def read_vehicle(
    data: Mapping[str, Any], cameras: Collection[CameraTable], problems: toml.Problems
) -> dict[str, Any]:
    """The holds, lights and joints of a robot file, by their fields of its description.

    Args:
        data: The file.
        cameras: The robot's cameras, whose lights have names too.
        problems: Gets the mistakes.
    """
    taken = {light.name for light in camera_lights(cameras)}
    return {
        "holds": _read(HoldTable, data, "hold", problems, key="kind"),
        "lights": _read(LightTable, data, "light", problems, taken=taken),
        "joints": _read(JointTable, data, "joint", problems),
    }


def camera_lights(cameras: Collection[CameraTable]) -> tuple[LightBody, ...]:
    """The lights of the cameras; that of the main camera is "headlight"."""
    return tuple(
        LightBody(name=f"headlight {table.name}" if place else "headlight", camera=table.name)
        for place, table in enumerate(cameras)
        if table.camera.headlight
    )


def _read(
    kind: type[Table],
    data: Mapping[str, Any],
    name: str,
    problems: toml.Problems,
    *,
    key: str = "name",
    taken: Collection[str] = (),
) -> tuple[Table, ...]:
    """The tables [[name]]; no two have the same name."""
    known = set(taken)

    def faults(table: Any) -> Iterator[tuple[str, str]]:  # noqa: ANN401 - any of the tables
        if table.name in known:
            yield key, f"there is another {name} {table.name!r}"
        known.add(table.name)
        if isinstance(table, JointTable) and table.lowest >= table.highest:
            low, high = math.degrees(table.lowest), math.degrees(table.highest)
            yield "lowest_deg", f"{low:g} is not less than 'highest_deg', {high:g}"

    return tuple(read_each(kind, data.get(name, []), name, problems, faults).values())
