"""The body of a robot: its outline, its motions, its sensors and cameras, each with its place.

Frames form a tree as in ROS's tf: each has a parent, and the root is `base_link` (REP 105). There x
points forward, y left, z up. Its origin is on the ground where the robot turns. A sensor's name is
that of its frame, and the `frame_id` of what it measures.
"""

from __future__ import annotations

import enum
import math
from typing import Annotated, TypeAlias

from hub.gcm.fields import Count, Flag, Length, LengthIfKnown, Metres, Name, Radians
from hub.gcm.standard import BASE_LINK
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import FLOAT32, Counted
from hub.values import dataclass

Metres32: TypeAlias = Annotated[Metres, FLOAT32]
MOST_CORNERS = 32
"""Most corners of a footprint."""
MOST_PARTS = 64
"""Most sensors, bumpers or cameras of one kind."""
MOST_BEAMS = 4096
"""Most beams of a scan."""
USUAL_RADIUS = 0.205
"""Radius of a robot that describes no outline [m]."""
USUAL_HEIGHT = 0.45
"""Height of a robot that describes none [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Point32:
    """geometry_msgs/Point32.

    Attributes:
        x: Forward [m].
        y: To the left [m].
        z: Up [m].
    """

    ros_type = "geometry_msgs/msg/Point32"

    x: Metres32
    y: Metres32
    z: Metres32 = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyFrame:
    """The constant pose of a frame in its parent.

    Each rotation turns the axes of the next one: yaw first, then pitch, then roll.

    Attributes:
        name: Its own name, such as "sonar" or "camera".
        parent: Name of its parent.
        x: Forward [m].
        y: To the left [m].
        z: Up [m].
        roll: About x [rad], positive right side down.
        pitch: About y [rad], positive nose down.
        yaw: About z [rad], counter-clockwise.
    """

    name: Name
    parent: Name = BASE_LINK
    x: Metres = 0.0
    y: Metres = 0.0
    z: Metres = 0.0
    roll: Radians = 0.0
    pitch: Radians = 0.0
    yaw: Radians = 0.0


class Freedom(enum.IntEnum):
    """A degree of freedom of the body, along or about an axis of `base_link`.

    Attributes:
        SURGE: Along x.
        SWAY: Along y.
        HEAVE: Along z.
        ROLL: About x.
        PITCH: About y.
        YAW: About z.
    """

    SURGE = 0
    SWAY = 1
    HEAVE = 2
    ROLL = 3
    PITCH = 4
    YAW = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A degree of freedom that velocity commands move.

    Attributes:
        freedom: Which one.
        limit: Largest velocity [m/s or rad/s].
        acceleration: Fastest change of it [m/s^2 or rad/s^2].
    """

    freedom: Freedom
    limit: Annotated[float, Range(0.0, 100.0, unit="m/s or rad/s")]
    acceleration: Annotated[float, Range(0.0, 1000.0, unit="m/s^2 or rad/s^2")]


class RangeKind(enum.IntEnum):
    """The principle of a range sensor.

    Attributes:
        SONAR: Sound in air: smooth walls reflect its wide beam away.
        INFRARED: The angle of reflected light: near and narrow.
        LASER: The time of flight of light; narrow.
        ECHO_SOUNDER: Sound in water.
    """

    SONAR = 0
    INFRARED = 1
    LASER = 2
    ECHO_SOUNDER = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeGroup:
    """Equal range sensors: a single one, a ring, or the beams of a planar scan.

    Beam i looks along `first` + i `step` in the xy-plane of the frame. Its range counts from
    the frame's origin, also where the sensor is on a ring around it.

    Attributes:
        name: Name of their frame.
        kind: Their principle.
        beams: Number of beams.
        first: Direction of beam 0 [rad].
        step: Angle from a beam to the next [rad], positive counter-clockwise.
        opening: Whole angle of one beam's cone [rad].
        ring: Distance of each sensor from the frame's origin [m].
        nearest: Least range [m].
        farthest: Largest range [m].
        rate_hz: Measurements per second [Hz].
    """

    name: Name
    kind: RangeKind
    beams: Annotated[int, Range(1, MOST_BEAMS)] = 1
    first: Radians = 0.0
    step: Radians = 0.0
    opening: Annotated[float, Range(0.0, math.pi, unit="rad")] = 0.0
    ring: Length = 0.0
    nearest: Length = 0.0
    farthest: Length
    rate_hz: Annotated[float, Range(0.0, 1000.0, unit="Hz")] = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Bumper:
    """One bumper on the outline.

    Attributes:
        name: Its name, such as "front left".
        direction: Direction of its middle from the centre [rad].
        width: Angle of the outline that it covers, from the centre [rad].
    """

    name: Name
    direction: Radians
    width: Annotated[float, Range(0.0, math.tau, unit="rad")]


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraBody:
    """One camera: its frame looks along x, with z up in the picture.

    Attributes:
        name: Name of its frame.
        horizontal_fov: Widest field of view from left to right [rad].
        width_px: Largest width of a picture; 0: not known.
        height_px: Largest height of a picture; 0: not known.
        pan_limit: Largest pan to either side [rad]; 0: fixed.
        tilt_lowest: Lowest tilt [rad].
        tilt_highest: Highest tilt [rad]; equal to the lowest: fixed.
        zoom: Largest magnification; 1: none.
        headlight: 1: it has a light, else 0.
    """

    name: Name
    horizontal_fov: Annotated[float, Range(1e-6, 3.1, unit="rad")]
    width_px: Count = 0
    height_px: Count = 0
    pan_limit: Annotated[float, Range(0.0, math.tau, unit="rad")] = 0.0
    tilt_lowest: Radians = 0.0
    tilt_highest: Radians = 0.0
    zoom: Annotated[float, Range(1.0, 1000.0)] = 1.0
    headlight: Flag = 0


class SenseKind(enum.IntEnum):
    """What a sensor of the air measures.

    Attributes:
        SOUND: The sound level.
        CO2: Carbon dioxide.
    """

    SOUND = 0
    CO2 = 1


class HoldKind(enum.IntEnum):
    """What a hold keeps.

    Attributes:
        HEIGHT: The height above the ground.
        DEPTH: The depth below the water's surface.
        HEADING: The heading.
        POSITION: The place in the plane.
    """

    HEIGHT = 0
    DEPTH = 1
    HEADING = 2
    POSITION = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldBody:
    """A hold that the body has.

    Attributes:
        kind: What it keeps.
        tolerance: It fails when the robot is farther off [m or rad]; 0: the body decides.
    """

    kind: HoldKind
    tolerance: Annotated[float, Range(0.0, 1000.0, unit="m or rad")] = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LightBody:
    """A light that can be switched.

    Attributes:
        name: Its name.
        camera: The camera that it belongs to; empty: the body.
    """

    name: Name
    camera: Name = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SenseBody:
    """A sensor of the air around the robot.

    Attributes:
        kind: What it measures.
    """

    kind: SenseKind


@dataclass(frozen=True, slots=True, kw_only=True)
class JointBody:
    """A joint that the operator moves, such as a pair of flippers.

    Attributes:
        name: Its name.
        lowest: Least angle [rad].
        highest: Largest angle [rad].
        speed: Largest turn rate [rad/s].
    """

    name: Name
    lowest: Radians
    highest: Radians
    speed: Annotated[float, Range(0.0, 100.0, unit="rad/s")]


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriedPart:
    """A message that the robot brings.

    Attributes:
        message: Its name.
        part: What it has, such as "ranges".
    """

    message: Name
    part: Name


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotBody:
    """The constants of a robot; the hub publishes them once and keeps them.

    Attributes:
        name: The robot's own name, from its robot file.
        kind: Its kind, such as "simulated-blimp".
        radius: Radius of the circle around the origin that encloses the robot [m].
        footprint: Corners of its outline on the ground, counter-clockwise, shape (n,); none:
            the circle.
        height: Its highest point above the ground [m]; NaN: not known.
        mass: [kg]; NaN: not known.
        motions: The degrees of freedom that velocity commands move; the others it cannot.
        frames: The frames of all sensors and cameras; a parent stands before its children.
        ranges: The range sensors, in the order in which their readings stand.
        bumpers: The bumpers; bit i of the readings is bumper i.
        cameras: The cameras, the main one first.
        left_alone: What it does without an operator, as robot files name it.
        holds: What it can hold while the operator commands no motion.
        lights: The lights, those of cameras too.
        joints: The joints that the operator moves, besides cameras.
        arms: 1: its motors can be armed and disarmed, else 0.
        senses: Its sensors of the air.
        messages: What the hub brings of this robot, at least; made from its parts and its kind.
    """

    name: Name
    kind: Name
    radius: Length
    footprint: Annotated[tuple[Point32, ...], Counted(), Most(MOST_CORNERS)] = ()
    height: LengthIfKnown = math.nan
    mass: Annotated[float, Range(0.0, 1e6, unit="kg", nan=True)] = math.nan
    motions: Annotated[tuple[Motion, ...], Counted("motion_count"), Most(len(Freedom))] = ()
    frames: Annotated[tuple[BodyFrame, ...], Counted("frame_count"), Most(3 * MOST_PARTS)] = ()
    ranges: Annotated[tuple[RangeGroup, ...], Counted("range_count"), Most(MOST_PARTS)] = ()
    bumpers: Annotated[tuple[Bumper, ...], Counted("bumper_count"), Most(MOST_PARTS)] = ()
    cameras: Annotated[tuple[CameraBody, ...], Counted("camera_count"), Most(MOST_PARTS)] = ()
    left_alone: Name = "stand"
    holds: Annotated[tuple[HoldBody, ...], Counted("hold_count"), Most(len(HoldKind))] = ()
    lights: Annotated[tuple[LightBody, ...], Counted("light_count"), Most(2 * MOST_PARTS)] = ()
    joints: Annotated[tuple[JointBody, ...], Counted("joint_count"), Most(MOST_PARTS)] = ()
    arms: Flag = 0
    senses: Annotated[tuple[SenseBody, ...], Counted("sense_count"), Most(len(SenseKind))] = ()
    messages: Annotated[tuple[CarriedPart, ...], Counted("message_count"), Most(MOST_PARTS)] = ()


ROBOT_DESCRIPTION = MessageDefinition(
    name="GCM_RobotDescription",
    type=RobotBody,
)

MESSAGES = (ROBOT_DESCRIPTION,)
