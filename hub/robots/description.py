"""The robot in a robot file: its kind, its body, its limits, the settings of its modules."""

from __future__ import annotations

import enum
import math
from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.gcm.body import (
    MOST_CORNERS,
    USUAL_RADIUS,
    BodyFrame,
    Freedom,
    Motion,
    Point32,
    RobotBody,
    SenseBody,
    SenseKind,
)
from hub.gcm.vehicle import Arming
from hub.recording.live.settings import RecordingTable
from hub.robots.body_tables import (
    BumperTable,
    CameraTable,
    RangeTable,
)
from hub.robots.fleet_table import FleetTable
from hub.robots.footprint import FARTHEST_CORNER, area, footprint_fault
from hub.robots.left_alone import SURFACE_AFTER_S, LeftAlone
from hub.robots.ros_table import RosTable
from hub.robots.vehicle_tables import HoldTable, JointTable, LightTable, camera_lights
from hub.toml_reader import choice, key, number, plain_name, several, text, whole_number
from hub.values import dataclass

NOTHING_NEW_S = 240.0
NOTHING_NEW_SHARE = 0.02
"""Exploring ends if the ground in reach grew by less than this share in this time [s]."""
LONGEST_EXPLORING_S = 600.0
"""Time after which an exploring robot is back at its start [s]."""

AUTOPILOT_KIND = "mavlink"
"""The kind of vehicles with an autopilot."""
SIMULATED_AUTOPILOT_KIND = "simulated-autopilot"
"""The kind of vehicles with a simulated autopilot in an arena."""


class Base(enum.Enum):
    """How a simulated body moves.

    Attributes:
        WHEELS: On wheels that may also go sideways; on rough ground a round base on two wheels.
        TRACKS: On tracks with flippers.
        BLIMP: In air.
        ROV: In water.
    """

    WHEELS = "wheels"
    TRACKS = "tracks"
    BLIMP = "blimp"
    ROV = "rov"


class MissionBegin(enum.Enum):
    """The event that starts a mission, besides a mark and the operator's order.

    Attributes:
        WITH_CONTROL: An operator who takes control of the robot.
        BY_HAND: Nothing.
    """

    WITH_CONTROL = "with control"
    BY_HAND = "by hand"


def _corners(value: object) -> tuple[tuple[float, float], ...]:
    """The corners of a body, in counter-clockwise order."""
    corners: tuple[tuple[float, float], ...]
    place = toml.numbers(2, -FARTHEST_CORNER, FARTHEST_CORNER)
    corners = toml.several(place, MOST_CORNERS)(value)
    fault = footprint_fault(corners)
    if fault:
        reason = f"{toml.shorten(value)} {fault}"
        raise toml.RefusedError(reason)
    return corners if area(corners) > 0.0 else corners[::-1]


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotDescription:
    """The robot in a robot file; each field has its `key` in the file.

    Attributes:
        path: The file.
        settings: Values that replace the file's, each as "TABLE.KEY=VALUE".
        frames: The frames of the body file's or the robot file's sensors and cameras.
        ranges: The tables of the range sensors.
        bumpers: The tables of the bumpers.
        cameras: The tables of the cameras, the main one first.
        holds: The tables of the holds.
        lights: The tables of the lights that belong to no camera.
        joints: The tables of the joints.
        recording: The table of recordings.
        ros: The table of a robot with ROS.
        fleet: How it joins a fleet; None: it does not.
        modules: The unchecked tables under [modules].
    """

    path: Path
    settings: tuple[str, ...]
    name: str = key(plain_name(32), meaning="the robot's name")
    kind: str = key(text(64), meaning="its kind: a shipped one, or `FILE:NAME` of your own")
    listen: str = key(
        text(60),
        "",
        "HOST:PORT of this machine where clients with the hub's token may connect by TCP",
        at="hub.",
        without="no TCP port",
    )
    gateway: str = key(
        text(100),
        "",
        "tcp:// address where machines with keys may connect",
        at="hub.",
        without="none may",
    )
    keys: str = key(text(200), "", "folder of the keys", at="hub.", without="the user's own")
    logs: str = key(
        text(1000),
        "",
        "folder for folders of log files",
        at="hub.",
        without="where the system has such files",
    )
    linear_limit: float = key(
        number(0.0, 3.0), 0.5, "largest forward velocity [m/s]; 0: it cannot", at="limits.linear"
    )
    angular_limit: float = key(
        number(0.0, 6.0), 1.0, "largest turn rate [rad/s]; 0: it cannot", at="limits.angular"
    )
    sway_limit: float = key(
        number(0.0, 3.0), 0.0, "largest velocity sideways [m/s]; 0: it cannot", at="limits.sway"
    )
    heave_limit: float = key(
        number(0.0, 3.0), 0.0, "largest velocity up and down [m/s]; 0: it cannot", at="limits.heave"
    )
    roll_limit: float = key(
        number(0.0, 6.0), 0.0, "largest roll rate [rad/s]; 0: it cannot", at="limits.roll"
    )
    pitch_limit: float = key(
        number(0.0, 6.0), 0.0, "largest pitch rate [rad/s]; 0: it cannot", at="limits.pitch"
    )
    linear_acceleration: float = key(
        number(0.05, 20.0),
        2.0,
        "fastest change of a linear velocity, braking [m/s^2]",
        at="limits.",
    )
    angular_acceleration: float = key(
        number(0.1, 50.0), 4.0, "fastest change of a turn rate, braking [rad/s^2]", at="limits."
    )
    radius: float = key(
        number(0.02, 5.0),
        math.nan,
        "circle around the robot's centre in which all of it lies [m]",
        at="body.",
        without=f"encloses the footprint, else {USUAL_RADIUS}",
    )
    footprint: tuple[tuple[float, float], ...] = key(
        _corners,
        (),
        "corners `[x, y]` of the ground that it covers [m], x forward, y left",
        at="body.",
        without="the circle",
    )
    height: float = key(
        number(0.01, 10.0),
        math.nan,
        "its highest point above the ground [m]",
        at="body.",
        without="not known",
    )
    mass: float = key(number(0.001, 1e6), math.nan, "[kg]", at="body.", without="not known")
    urdf: str = key(
        text(1000),
        "",
        "a URDF file with the robot's outline, and frames for its sensors",
        at="body.",
        without="none",
    )
    margin: float = key(
        number(0.0, 1.0), 0.05, "how far navigation keeps from obstacles besides [m]", at="body."
    )
    arming: Arming = key(
        choice({each.name.lower(): each for each in Arming}),
        Arming.NONE,
        "whether its motors can be disarmed, and how they start: `armed` or `disarmed`",
        at="body.",
        without="`none`: they cannot",
    )
    senses: tuple[SenseKind, ...] = key(
        several(choice({each.name.lower(): each for each in SenseKind}), len(SenseKind)),
        (),
        "what it measures of the air: a list of `sound`, `co2`",
        at="body.",
        without="nothing",
    )
    step: float = key(
        number(0.0, 5.0),
        0.05,
        "highest step that it drives over, up or down [m]; a higher one down is an edge",
        at="body.",
    )
    left_alone: LeftAlone = key(
        choice({each.value: each for each in LeftAlone}),
        LeftAlone.STAND,
        "what it does when it has lost its operator",
        at="safety.",
    )
    surface_after_s: float = key(
        number(0.0, 3600.0),
        SURFACE_AFTER_S,
        "how long it stays neutral before it surfaces [s]",
        at="safety.",
    )
    map_resolution: float = key(
        number(0.01, 1.0), 0.05, "edge of a cell of the map [m]", at="mapping.resolution"
    )
    map_size: float = key(
        number(1.0, 1000.0), 40.0, "extent of the map in both directions [m]", at="mapping.size"
    )
    map_folder: str = key(
        text(1000), "", "where maps are saved", at="mapping.folder", without="the user's own"
    )
    mission_folder: str = key(
        text(1000), "", "where missions are kept", at="mission.folder", without="the user's own"
    )
    mission_begin: MissionBegin = key(
        choice({each.value: each for each in MissionBegin}),
        MissionBegin.WITH_CONTROL,
        "what begins a mission, besides a mark and the operator's word",
        at="mission.begin",
    )
    mission_largest_mb: float = key(
        number(1.0, 1e6),
        500.0,
        "size of a mission from which on only marks are kept [MB]",
        at="mission.largest_mb",
    )
    mission_least_free_mb: float = key(
        number(0.0, 1e6),
        50.0,
        "room on the disk below which only marks are kept [MB]",
        at="mission.least_free_mb",
    )
    nothing_new_s: float = key(
        number(5.0, 86400.0),
        NOTHING_NEW_S,
        "exploring ends when nothing new came for this time, although it drove [s]",
        at="autonomy.",
    )
    nothing_new_share: float = key(
        number(0.0, 1.0),
        NOTHING_NEW_SHARE,
        "nothing new: the ground in reach grew by less than this share",
        at="autonomy.",
    )
    longest_exploring_s: float = key(
        number(30.0, 86400.0),
        LONGEST_EXPLORING_S,
        "exploring turns back in time to be at the start after this time [s]",
        at="autonomy.longest_s",
    )
    arena: str = key(text(200), "yellow", "a shipped arena, or the path of one", at="simulation.")
    base: Base = key(
        choice({each.value: each for each in Base}),
        Base.WHEELS,
        "how a simulated body moves: on wheels, on tracks, in air, in water",
        at="simulation.",
    )
    seed: int = key(
        whole_number(0, 2**63 - 1), 1, "the same seed gives the same run", at="simulation."
    )
    leaks_after_s: float = key(
        number(0.0, 1e6),
        math.inf,
        "time after which a simulated underwater robot has a leak [s]",
        at="simulation.",
        without="never",
    )
    light: float | None = key(
        number(0.0, 1.0),
        None,
        "how bright the arena is; 0 is dark",
        at="simulation.",
        without="as the arena's file says",
    )
    vehicle_address: str = key(
        text(200),
        "",
        "of an autopilot: `udp://:14550`, `udp://HOST:PORT`, `tcp://HOST:PORT`, `/dev/ttyACM0`",
        at="mavlink.address",
    )
    vehicle_system: int = key(
        whole_number(0, 255), 0, "number of the vehicle; 0: the first one", at="mavlink.system"
    )
    vehicle_kind: str = key(
        text(20),
        "",
        "kind of vehicle that the file is for, such as rover: no other one is driven",
        at="mavlink.vehicle",
        without="any",
    )
    vehicle_station: int = key(
        whole_number(1, 255),
        255,
        "number of this hub as a ground station; the vehicle's MAV_GCS_SYSID",
        at="mavlink.station",
    )
    signing_key: str = key(
        text(1000), "", "file of a key that signs", at="mavlink.key_file", without="unsigned"
    )
    frames: tuple[BodyFrame, ...] = ()
    ranges: tuple[RangeTable, ...] = ()
    bumpers: tuple[BumperTable, ...] = ()
    cameras: tuple[CameraTable, ...] = ()
    holds: tuple[HoldTable, ...] = ()
    lights: tuple[LightTable, ...] = ()
    joints: tuple[JointTable, ...] = ()
    recording: RecordingTable = RecordingTable()
    ros: RosTable = RosTable()
    fleet: FleetTable | None = None
    modules: dict[str, Any]

    @property
    def camera(self) -> CameraTable:
        """The main camera."""
        return self.cameras[0] if self.cameras else CameraTable()

    @property
    def body(self) -> RobotBody:
        """The robot's body, as the hub publishes it."""
        return RobotBody(
            name=self.name,
            kind=self.kind,
            radius=self.radius,
            footprint=tuple(Point32(x=x, y=y) for x, y in self.footprint),
            height=self.height,
            mass=self.mass,
            motions=self._motions(),
            frames=self.frames,
            ranges=tuple(table.sensors for table in self.ranges),
            bumpers=tuple(bumper for table in self.bumpers for bumper in table.bumpers),
            cameras=tuple(table.camera for table in self.cameras),
            left_alone=self.left_alone.value,
            holds=tuple(table.hold for table in self.holds),
            lights=(*camera_lights(self.cameras), *(table.light for table in self.lights)),
            joints=tuple(table.joint for table in self.joints),
            arms=int(self.arming is not Arming.NONE),
            senses=tuple(SenseBody(kind=kind) for kind in self.senses),
        )

    def _motions(self) -> tuple[Motion, ...]:
        """The degrees of freedom with a limit above 0."""
        limits = {
            Freedom.SURGE: (self.linear_limit, self.linear_acceleration),
            Freedom.SWAY: (self.sway_limit, self.linear_acceleration),
            Freedom.HEAVE: (self.heave_limit, self.linear_acceleration),
            Freedom.ROLL: (self.roll_limit, self.angular_acceleration),
            Freedom.PITCH: (self.pitch_limit, self.angular_acceleration),
            Freedom.YAW: (self.angular_limit, self.angular_acceleration),
        }
        return tuple(
            Motion(freedom=freedom, limit=limit, acceleration=acceleration)
            for freedom, (limit, acceleration) in limits.items()
            if limit > 0.0
        )

    @property
    def simulated(self) -> bool:
        """Whether its hardware is a simulation."""
        return bool(self.kind) and self.kind.startswith("simulated-")

    @property
    def has_autopilot(self) -> bool:
        """Whether it is driven over MAVLink."""
        return self.kind in (AUTOPILOT_KIND, SIMULATED_AUTOPILOT_KIND)


def settings(module: str) -> str:
    """The robot file's settings for a module, in words; empty: none."""
    tables = {
        **toml.tables_of(RobotDescription),
        "recorder": toml.keys_of(RecordingTable),
        "fleet": toml.keys_of(FleetTable),
    }
    words = [
        f"{name} ({toml.shown(each)}): {each.meaning}"
        for name, each in tables.get(module, {}).items()
    ]
    table = "recording" if module == "recorder" else module
    return f"its table [{table}] has: {'; '.join(words)}" if words else ""
