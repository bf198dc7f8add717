"""The kinds of robots, and the functions that open their hardware."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hub.errors import CameraError, UnknownKindError
from hub.gcm.battery import BATTERY
from hub.gcm.body import RobotBody
from hub.gcm.flight import ALTITUDE, FLUID_PRESSURE
from hub.gcm.ground_truth import GROUND_TRUTH
from hub.gcm.imu import IMU
from hub.ipc.definition import MessageDefinition
from hub.nearest import did_you_mean
from hub.robots.body_tables import ROBOTS_OWN, CameraTable
from hub.robots.description import AUTOPILOT_KIND, SIMULATED_AUTOPILOT_KIND, Base, RobotDescription
from hub.robots.interfaces import Body, Camera, OwnMap
from hub.robots.messages_of import described
from hub.robots.robot_file import shipped_bodies
from hub.robots.ros_table import ROS_KIND
from hub.values import dataclass

if TYPE_CHECKING:
    from hub.robots.ros.line import RosLine


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotKind:
    """The functions that open the hardware of one kind of robot; each module opens its own part.

    Attributes:
        open_body: Opens wheels, range sensors, bumpers, battery.
        open_camera: Opens a camera of its own, by its table in the robot file; None: it has none.
            Use the function `open_camera`.
        open_map: Opens the map that the robot makes itself; None: it makes none.
        measures: The messages of what the hardware measures besides the described parts.
        modes: Whether the body is a `BodyModes`.
        imports: Python modules that the two functions import. The daemon imports them once, for
            all modules of the robot; they start no threads.
    """

    open_body: Callable[[RobotDescription], Body]
    open_camera: Callable[[RobotDescription, CameraTable], Camera] | None = None
    open_map: Callable[[RobotDescription], OwnMap | None] = lambda _: None
    measures: Callable[[RobotDescription], tuple[MessageDefinition[Any], ...]] = lambda _: ()
    modes: bool = False
    imports: tuple[str, ...] = ()


def _simulated_body(robot: RobotDescription) -> Body:
    from hub.robots.simulated_base import SimulatedBase
    from hub.sim.arena import load_arena

    arena = load_arena(robot.arena)
    match robot.base:
        case Base.BLIMP:
            from hub.robots.simulated_floats import BlimpBody

            return BlimpBody(arena, robot.body, seed=robot.seed)
        case Base.ROV:
            from hub.robots.simulated_floats import RovBody

            return RovBody(arena, robot.body, seed=robot.seed, leaks_at=robot.leaks_after_s)
        case Base.WHEELS if arena.ground is None:
            return SimulatedBase(arena, robot.body, seed=robot.seed)
    from hub.robots.simulated_rough_base import RoughBody
    from hub.sim.ground.chassis import TRACKED, WHEELED

    chassis = TRACKED if robot.base is Base.TRACKS else WHEELED
    return RoughBody(arena, robot.body, chassis, seed=robot.seed)


def _simulated_camera(robot: RobotDescription, table: CameraTable) -> Camera:
    from hub.gcm.frames import in_base
    from hub.robots.simulated_camera import SimulatedCamera
    from hub.sim.arena import load_arena

    return SimulatedCamera(
        load_arena(robot.arena),
        body=table.camera,
        mount=in_base(robot.body.frames, table.name) or table.frame,
        light=robot.light,
        headlight=table.headlight and not table.heat,
        heat=table.heat,
        seed=robot.seed,
    )


def _simulated_measures(robot: RobotDescription) -> tuple[MessageDefinition[Any], ...]:
    from hub.sim.arena import load_arena

    match robot.base:
        case Base.ROV:
            return BATTERY, IMU, ALTITUDE, FLUID_PRESSURE, GROUND_TRUTH
        case Base.BLIMP:
            return BATTERY, IMU, ALTITUDE, GROUND_TRUTH
        case Base.WHEELS if load_arena(robot.arena).ground is None:
            return BATTERY, GROUND_TRUTH
    return BATTERY, IMU, GROUND_TRUTH


def _autopilot_body(robot: RobotDescription) -> Body:
    from hub.robots.mavlink.body import MavlinkBody

    return MavlinkBody(robot)


def _simulated_autopilot_body(robot: RobotDescription) -> Body:
    from hub.robots.simulated_autopilot.body import SimulatedAutopilotBody

    return SimulatedAutopilotBody(robot)


def _line_of(robot: RobotDescription) -> RosLine:
    from hub.robots.ros.address import ros_address
    from hub.robots.ros.opening import line_to

    return line_to(ros_address(robot.ros.address), robot.ros.certificates)


def _ros_body(robot: RobotDescription) -> Body:
    from hub.robots.ros.address import ros_address
    from hub.robots.ros.body import RosBody
    from hub.robots.ros.robot_claim import RobotClaim

    claim = RobotClaim(ros_address(robot.ros.address), robot.ros.cmd_vel, robot.ros.known_as)
    return RosBody(robot, _line_of(robot), claim=claim)


def _ros_camera(robot: RobotDescription, table: CameraTable) -> Camera:
    from hub.robots.ros.camera import RosCamera

    return RosCamera(_line_of(robot), table)


def _ros_map(robot: RobotDescription) -> OwnMap | None:
    from hub.robots.ros.own_map import RosMap

    return RosMap(_line_of(robot), robot.ros) if robot.ros.map else None


def _ros_measures(robot: RobotDescription) -> tuple[MessageDefinition[Any], ...]:
    measures: dict[MessageDefinition[Any], object] = {
        BATTERY: robot.ros.battery,
        IMU: robot.ros.imu,
        FLUID_PRESSURE: robot.ros.pressure,
        ALTITUDE: robot.heave_limit,
    }
    return tuple(message for message, given in measures.items() if given)


def _autopilot_measures(robot: RobotDescription) -> tuple[MessageDefinition[Any], ...]:
    return BATTERY, IMU, *((ALTITUDE, FLUID_PRESSURE) if robot.heave_limit else ())


_AUTOPILOT = RobotKind(
    open_body=_autopilot_body,
    measures=_autopilot_measures,
    modes=True,
    imports=("hub.robots.mavlink.body",),
)
_SIMULATED_AUTOPILOT = RobotKind(
    open_body=_simulated_autopilot_body,
    open_camera=_simulated_camera,
    measures=lambda robot: (*_autopilot_measures(robot), GROUND_TRUTH),
    modes=True,
    imports=("hub.robots.simulated_autopilot.body", "hub.robots.simulated_camera", "numpy.random"),
)
_ROS = RobotKind(
    open_body=_ros_body,
    open_camera=_ros_camera,
    open_map=_ros_map,
    measures=_ros_measures,
    imports=("hub.robots.ros.body", "hub.robots.ros.camera", "hub.robots.ros.opening"),
)
_SIMULATED = RobotKind(
    open_body=_simulated_body,
    open_camera=_simulated_camera,
    measures=_simulated_measures,
    imports=("hub.robots.simulated_camera", "hub.robots.simulated_base", "numpy.random"),
)
KINDS = {
    "simulated-wheels": _SIMULATED,
    AUTOPILOT_KIND: _AUTOPILOT,
    SIMULATED_AUTOPILOT_KIND: _SIMULATED_AUTOPILOT,
    ROS_KIND: _ROS,
    **dict.fromkeys(shipped_bodies(), _SIMULATED),
}
"""Each kind that Rune ships; a kind with a file of its own in `bodies/` has that body."""


def kind_of(robot: RobotDescription) -> RobotKind:
    """The kind in a robot file: a built-in one, or "file:NAME" of a Python file beside it.

    Raises:
        UnknownKindError: There is none of that name, or the Python file cannot be imported.
    """
    known = KINDS.get(robot.kind)
    if known is not None:
        return known
    module, colon, name = robot.kind.partition(":")
    if not (colon and name.isidentifier() and all(map(str.isidentifier, module.split(".")))):
        text = (
            f"kind {robot.kind!r} is none of {', '.join(KINDS)}, and no file:NAME of a Python file"
            f" beside the robot file{did_you_mean(robot.kind, KINDS)}"
        )
        raise UnknownKindError(text)
    folder = str(robot.path.resolve().parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    try:
        kind = getattr(importlib.import_module(module), name)
    except Exception as error:  # a robot's own file may raise anything
        text = f"kind {robot.kind!r} cannot be imported: {type(error).__name__}: {error}"
        raise UnknownKindError(text) from error
    if not isinstance(kind, RobotKind):
        text = f"kind {robot.kind!r} is no RobotKind but a {type(kind).__name__}"
        raise UnknownKindError(text)
    return kind


def body_of(robot: RobotDescription) -> RobotBody:
    """The robot's body with the messages that it brings, as the hub publishes it.

    Raises:
        UnknownKindError: The robot is of no known kind.
    """
    return described(robot.body, kind_of(robot).measures(robot))


def open_camera(robot: RobotDescription, table: CameraTable) -> Camera:
    """A camera in a robot file: one of the robot's own, or another.

    Raises:
        CameraError: The robot has none, or the file names an address of an unknown kind.
        UnknownKindError: The robot is of no known kind.
    """
    if table.source == ROBOTS_OWN:
        open_own = kind_of(robot).open_camera
        if open_own is None:
            text = f"{robot.name} has no camera of its own; name one in [camera], key 'source'"
            raise CameraError(text)
        return open_own(robot, table)
    from hub.robots.video_camera import VideoCamera

    return VideoCamera(
        table.source,
        horizontal_fov=table.fov,
        forward=table.forward,
        height=table.height,
    )


def camera_moves(robot: RobotDescription) -> bool:
    """Whether a camera in a robot file has a head that moves."""
    return any(
        table.source == ROBOTS_OWN
        and (table.pan_limit > 0.0 or table.tilt_lowest < table.tilt_highest or table.zoom > 1.0)
        for table in robot.cameras
    )
