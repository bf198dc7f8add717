"""The tables of a robot file that describe its body: frames, range sensors, bumpers, cameras.

Lengths are in metres. The `key` of a field declares its reader, its values and its meaning; the
tables of `docs/writing-a-robot.md` come from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from hub import toml_reader as toml
from hub.errors import CameraError
from hub.gcm.body import (
    MOST_BEAMS,
    MOST_PARTS,
    BodyFrame,
    Bumper,
    CameraBody,
    RangeGroup,
    RangeKind,
)
from hub.gcm.standard import BASE_LINK
from hub.nearest import did_you_mean
from hub.robots.ros_table import ros_name
from hub.robots.video_source import video_source
from hub.toml_reader import choice, degrees, key, number, plain_name, text, truth, whole_number
from hub.values import dataclass

Table = TypeVar("Table")

ROBOTS_OWN = "robot"
"""The source of pictures for the robot's own camera."""

MOST_BEAMS_IN_ALL = 8192
"""Most beams of all range sensors: ten times a second navigation and mapping look at each."""

_PLACE = number(-10.0, 10.0)
_ANGLE = degrees(-360.0, 360.0)
_NAME = plain_name(32)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameTable:
    """A `[[frame]]`: a part of the body whose place others count from."""

    name: str = key(_NAME, meaning="its name")
    parent: str = key(_NAME, BASE_LINK, "the frame that its place counts from")
    forward: float = key(_PLACE, 0.0, "its place ahead of the parent's [m]")
    left: float = key(_PLACE, 0.0, "its place to the left of the parent's [m]")
    height: float = key(_PLACE, 0.0, "its place above the parent's [m]")
    roll: float = key(_ANGLE, 0.0, "right side down [degrees]", at="roll_deg")
    pitch: float = key(_ANGLE, 0.0, "nose down [degrees]", at="pitch_deg")
    yaw: float = key(_ANGLE, 0.0, "to the left [degrees]", at="yaw_deg")

    @property
    def frame(self) -> BodyFrame:
        """Its pose in its parent."""
        return BodyFrame(
            name=self.name,
            parent=self.parent,
            x=self.forward,
            y=self.left,
            z=self.height,
            roll=math.remainder(self.roll, math.tau),
            pitch=math.remainder(self.pitch, math.tau),
            yaw=math.remainder(self.yaw, math.tau),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeTable(FrameTable):
    """A `[[range]]`: one range sensor, a ring of equal ones, or a scan of a plane."""

    kind: RangeKind = key(
        choice({each.name.lower().replace("_", " "): each for each in RangeKind}),
        meaning="its principle",
    )
    beams: int = key(whole_number(1, MOST_BEAMS), 1, "number of sensors, or of a scan's beams")
    first: float = key(_ANGLE, 0.0, "direction of the first [degrees]", at="first_deg")
    spread: float = key(
        degrees(-360.0, 360.0),
        math.tau,
        "from the first beam to the last, to the left; 360: all around [degrees]",
        at="spread_deg",
        without="360",
    )
    opening: float = key(
        degrees(0.0, 180.0), 0.0, "whole cone of a beam [degrees]", at="opening_deg"
    )
    ring: float = key(
        number(0.0, 5.0),
        0.0,
        "distance of each sensor from their place [m]",
    )
    nearest: float = key(
        number(0.0, 1000.0), 0.0, "least range, from their place; as `farthest`: a fixed one [m]"
    )
    farthest: float = key(number(0.01, 1000.0), meaning="largest range, from their place [m]")
    rate_hz: float = key(number(0.01, 1000.0), 10.0, "measurements per second [Hz]")
    topic: str = key(ros_name, "", "of a robot with ROS: topic of its LaserScan or Range")

    @property
    def sensors(self) -> RangeGroup:
        """What the hub publishes of it."""
        around = math.isclose(abs(self.spread), math.tau)
        steps = self.beams if around else self.beams - 1
        return RangeGroup(
            name=self.name,
            kind=self.kind,
            beams=self.beams,
            first=math.remainder(self.first, math.tau),
            step=self.spread / steps if self.beams > 1 else 0.0,
            opening=self.opening,
            ring=self.ring,
            nearest=self.nearest,
            farthest=self.farthest,
            rate_hz=self.rate_hz,
        )


def _source(value: object) -> str:
    source: str = text(1000)(value)
    try:
        video_source(source)
    except CameraError as error:
        raise toml.RefusedError(str(error)) from error
    return source


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraTable(FrameTable):
    """The `[camera]`, or each `[[camera]]` where there are several; the main one first."""

    name: str = key(_NAME, "camera", "its name")
    height: float = key(number(0.0, 10.0), 0.3, "its place above the parent's [m]")
    source: str = key(
        _source,
        ROBOTS_OWN,
        "where pictures come from: `robot`, or a device, a file, a network address",
    )
    fov: float = key(
        degrees(1.0, 170.0),
        math.radians(60.0),
        "widest field of view from left to right [degrees]",
        at="fov_deg",
        without="60",
    )
    width_px: int = key(whole_number(0, 10_000), 0, "largest width of a picture; 0: not known")
    height_px: int = key(whole_number(0, 10_000), 0, "largest height of a picture; 0: not known")
    pan_limit: float = key(
        degrees(0.0, 360.0),
        0.0,
        "largest pan [degrees]; 0: none",
        at="pan_limit_deg",
    )
    tilt_lowest: float = key(degrees(-180.0, 0.0), 0.0, "[degrees]", at="tilt_lowest_deg")
    tilt_highest: float = key(degrees(0.0, 180.0), 0.0, "[degrees]", at="tilt_highest_deg")
    zoom: float = key(number(1.0, 1000.0), 1.0, "largest magnification; 1: none")
    headlight: bool = key(truth, default=True, meaning="whether the robot's own camera has one")
    heat: bool = key(
        truth, default=False, meaning="whether a simulated one sees temperatures, not colours"
    )
    topic: str = key(ros_name, "", "of a robot with ROS: topic of its Image or CompressedImage")
    info: str = key(
        ros_name, "", "of a robot with ROS: topic of its CameraInfo", without="`fov_deg` counts"
    )

    @property
    def camera(self) -> CameraBody:
        """What the hub publishes of it."""
        return CameraBody(
            name=self.name,
            horizontal_fov=self.fov,
            width_px=self.width_px,
            height_px=self.height_px,
            pan_limit=self.pan_limit,
            tilt_lowest=self.tilt_lowest,
            tilt_highest=self.tilt_highest,
            zoom=self.zoom,
            headlight=int(
                self.headlight and not self.heat and self.source == ROBOTS_OWN and not self.topic
            ),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class BumperTable:
    """A `[[bumper]]`: one bumper, or several evenly all around."""

    name: str = key(_NAME, meaning="its name")
    direction: float = key(_ANGLE, 0.0, "of its middle [degrees], to the left", at="direction_deg")
    width: float = key(
        degrees(0.1, 360.0),
        math.radians(90.0),
        "its part of the outline [degrees]",
        at="width_deg",
        without="90",
    )
    count: int = key(
        whole_number(1, MOST_PARTS), 1, "how many: this one first, the others to the left"
    )

    @property
    def bumpers(self) -> tuple[Bumper, ...]:
        """What the hub publishes of it."""
        step = math.tau / self.count
        return tuple(
            Bumper(
                name=f"{self.name} {place}" if self.count > 1 else self.name,
                direction=math.remainder(self.direction + place * step, math.tau),
                width=self.width,
            )
            for place in range(self.count)
        )


def read_each(
    kind: type[Table],
    values: object,
    name: str,
    problems: toml.Problems,
    checked: Callable[[Table], Iterator[tuple[str, str]]] = lambda _: iter(()),
) -> dict[str, Table]:
    """The tables [[name]] of a robot file without mistakes, by their place in the file.

    Args:
        kind: The dataclass of one table.
        values: What the file has at this name.
        name: The name.
        problems: Gets the mistakes.
        checked: Key and sentence of each further mistake of a table.
    """
    if not isinstance(values, list):
        problems.add(toml.TOP, f"{name} has to be tables: [[{name}]]", name)
        return {}
    if len(values) > MOST_PARTS:
        problems.add(toml.TOP, f"more than {MOST_PARTS} tables [[{name}]]", name)
        return {}
    read: dict[str, Table] = {}
    for count, each in enumerate(values, start=1):
        place, before = toml.repeated(name, count), len(problems)
        fields = toml.read_table(toml.keys_of(kind), each, place, problems)
        if len(problems) == before:
            read[place] = table = kind(**fields)
            for which, text in checked(table):
                problems.add(place, f"{place}, key '{which}': {text}", which)
    return read


def range_faults(table: RangeTable) -> Iterator[tuple[str, str]]:
    """The mistakes of a range sensor whose keys are right."""
    if table.nearest > table.farthest:
        yield "nearest", f"{table.nearest:g} m is more than 'farthest', {table.farthest:g} m"
    if table.ring >= table.farthest:
        yield "ring", f"{table.ring:g} m is not less than 'farthest', {table.farthest:g} m"


def frame_tree(
    tables: Mapping[str, FrameTable], given: Mapping[str, BodyFrame], problems: toml.Problems
) -> tuple[BodyFrame, ...]:
    """The frames of the tables and of their parents; a parent stands before its children.

    Args:
        tables: The tables with a frame, by their place in the robot file.
        given: Further frames, such as those of a URDF file, by name; only parents are taken.
        problems: Gets the names that occur twice, the unknown parents, and circles.
    """
    known: dict[str, BodyFrame] = {}
    for place, table in tables.items():
        if table.name in known or table.name == BASE_LINK:
            text = f"{place}, key 'name': {table.name!r} is the name of another frame"
            problems.add(place, text, "name")
        known[table.name] = table.frame
    named = {**given, **known}
    ordered: dict[str, BodyFrame] = {}
    for place, table in tables.items():
        chain: dict[str, BodyFrame] = {}
        name = table.name
        while name in named and name not in chain and name not in ordered:
            chain[name] = named[name]
            name = chain[name].parent
        if name == BASE_LINK or name in ordered:
            ordered |= dict(reversed(chain.items()))
        elif name in chain:
            text = f"{place}, key 'parent': {table.parent!r} leads back to {name!r}"
            problems.add(place, text, "parent")
        else:
            text = f"{place}, key 'parent': {name!r} is no frame{did_you_mean(name, named)}"
            problems.add(place, text, "parent")
    return tuple(ordered.values())
