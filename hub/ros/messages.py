"""Messages of ROS 2 as those of Rune that say the same; values that Rune does not allow are cut."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.gcm.body import MOST_BEAMS, MOST_PARTS, RangeGroup, RangeKind
from hub.gcm.diagnostics import MOST_PROBLEMS, Diagnostics, DiagnosticStatus, Severity
from hub.gcm.fields import FARTHEST_M
from hub.gcm.flight import FluidPressure
from hub.gcm.geometry import Quaternion, Vector3
from hub.gcm.imu import Acceleration, Imu
from hub.gcm.joints import JointStates
from hub.gcm.navigation import MOST_POINTS, Point
from hub.gcm.orientation import angles
from hub.gcm.ranges import LaserScan, as_measured
from hub.gcm.standard import Header, Time
from hub.ros.frame_tree import HERE, FramePlace, pose_of, turn_of
from hub.ros.values import RosValue

_NAME: Final = 64
_SENTENCE: Final = 1000
_INFRARED: Final = 1
_BUMP: Final = 1


def header(value: RosValue) -> Header:
    """A std_msgs/Header."""
    stamp = value.get("stamp")
    seconds, rest = int(stamp.get("sec")), int(stamp.get("nanosec"))
    time = Time(sec=max(0, seconds), nanosec=min(rest, 999_999_999))
    return Header(stamp=time, frame_id=str(value.get("frame_id"))[:_NAME])


def imu(value: RosValue, mount: FramePlace = HERE) -> Imu:
    """A sensor_msgs/Imu, turned from its own frame into that of the body."""
    spin = mount.turn @ _vector(value.get("angular_velocity"), 100.0)
    push = mount.turn @ _vector(value.get("linear_acceleration"), 1e5)
    turn = turn_of(value.get("orientation"))  # drivers without a filter leave it 0
    attitude = _covariance(value, "orientation_covariance")
    known = turn is not None and attitude[0] >= 0.0
    orientation = Quaternion()
    if turn is not None and known:
        orientation = Quaternion.of(*angles(turn @ mount.turn.T))
    covariances = {
        name: _turned(_covariance(value, name), mount)
        for name in ("angular_velocity_covariance", "linear_acceleration_covariance")
    }
    if not known:
        attitude[0] = -1.0
    for name, each in zip(covariances, (spin, push), strict=True):
        if not np.isfinite(each).all():
            each[:] = 0.0
            covariances[name][0] = -1.0
    return Imu(
        header=header(value.get("header")),
        orientation=orientation,
        orientation_covariance=attitude,
        angular_velocity=Vector3(**dict(zip("xyz", spin.tolist(), strict=True))),
        linear_acceleration=Acceleration(**dict(zip("xyz", push.tolist(), strict=True))),
        **covariances,
    )


def fluid_pressure(value: RosValue) -> FluidPressure:
    """A sensor_msgs/FluidPressure."""
    pressure = known_number(value, "fluid_pressure", 0.0, 1e9)
    if math.isnan(pressure):
        text = "a pressure is not measured"
        raise RosMessageError(text)
    return FluidPressure(header=header(value.get("header")), fluid_pressure=pressure)


def joint_states(value: RosValue) -> JointStates:
    """A sensor_msgs/JointState; what is missing of a joint is not known."""
    names = tuple(str(name)[:_NAME] for name in value.get("name"))[:MOST_PARTS]

    def padded(part: str) -> npt.NDArray[np.float64]:
        numbers = np.full(len(names), np.nan)
        given = np.asarray(value.get(part), np.float64)[: len(names)]
        numbers[: len(given)] = given
        return numbers

    return JointStates(
        header=header(value.get("header")),
        name=names,
        position=padded("position"),
        velocity=padded("velocity"),
        effort=padded("effort"),
    )


def diagnostics(value: RosValue) -> Diagnostics:
    """A diagnostic_msgs/DiagnosticArray without the parts that are well."""
    problems: list[DiagnosticStatus] = []
    for each in value.get("status"):
        level = int(each.get("level")) & 0xFF
        if level and len(problems) < MOST_PROBLEMS:
            problems.append(
                DiagnosticStatus(
                    level=Severity(level) if level <= Severity.STALE else Severity.ERROR,
                    name=str(each.get("name"))[:_NAME],
                    message=str(each.get("message"))[:_SENTENCE],
                    hardware_id=str(each.get("hardware_id"))[:_NAME],
                )
            )
    return Diagnostics(header=header(value.get("header")), status=tuple(problems))


def laser_scan(
    value: RosValue, name: str, nearest: float | None = None
) -> tuple[RangeGroup, LaserScan]:
    """A sensor_msgs/LaserScan and its sensor; of too many beams, the nearest of neighbours count.

    Args:
        value: The message.
        name: Name of the sensor's frame.
        nearest: Least range that counts [m]; None: that of the message.
    """
    step, first = float(value.get("angle_increment")), float(value.get("angle_min"))
    with np.errstate(over="ignore"):  # beyond all numbers is beyond all ranges
        ranges = np.array(value.get("ranges"), np.float32)
    near, far = float(value.get("range_min")), float(value.get("range_max"))
    known = all(map(math.isfinite, (step, first, near, far)))
    if not (ranges.size and known and abs(step) <= math.tau):
        text = "a scan has no beams, or its angles make no sense"
        raise RosMessageError(text)
    near = near if nearest is None else nearest
    near, far = (min(1000.0, max(0.0, each)) for each in (near, far))
    if not near <= far or not far:  # else all of them would be nothing within reach
        text = f"the largest range of a scan is {far:g} m, its least {near:g} m"
        raise RosMessageError(text)
    ranges = as_measured(ranges, near, far)
    many = -(-len(ranges) // MOST_BEAMS)
    if many > 1:
        whole = len(ranges) // many * many
        with np.errstate(all="ignore"):
            ranges = np.fmin.reduce(ranges[:whole].reshape(-1, many), axis=1)
        first, step = first + step * (many - 1) / 2.0, step * many
    first = math.remainder(first, math.tau)
    group = RangeGroup(
        name=name,
        kind=RangeKind.LASER,
        beams=len(ranges),
        first=first,
        step=step,
        nearest=near,
        farthest=far,
    )
    return group, _scan(group, ranges, value)


def single_range(
    value: RosValue, name: str, nearest: float | None = None
) -> tuple[RangeGroup, LaserScan]:
    """A sensor_msgs/Range and its sensor; as for `laser_scan`."""
    infrared = int(value.get("radiation_type")) == _INFRARED
    far = known_number(value, "max_range", 0.0, 1000.0)
    near = known_number(value, "min_range", 0.0, 1000.0)
    near = near if nearest is None else nearest
    if not near <= far or not far:
        text = "a range sensor has no limits that make sense"
        raise RosMessageError(text)
    group = RangeGroup(
        name=name,
        kind=RangeKind.INFRARED if infrared else RangeKind.SONAR,
        opening=min(math.pi, max(0.0, float(value.get("field_of_view")) or 0.0)),
        nearest=near,
        farthest=far,
    )
    with np.errstate(over="ignore"):
        ranges = np.array([float(value.get("range"))], np.float32)
    return group, _scan(group, as_measured(ranges, near, far), value)


def _scan(group: RangeGroup, ranges: npt.NDArray[np.float32], value: RosValue) -> LaserScan:
    return LaserScan(
        header=Header(stamp=header(value.get("header")).stamp, frame_id=group.name),
        angle_min=group.first,
        angle_max=group.first + group.step * (group.beams - 1),
        angle_increment=group.step,
        range_min=group.nearest,
        range_max=group.farthest,
        ranges=ranges,
        intensities=np.empty(0, np.float32),
    )


def path_points(value: RosValue, moved: FramePlace) -> tuple[Point, ...]:
    """The points of a nav_msgs/Path, some of them where they are too many."""
    poses = value.get("poses")
    every = max(1, -(-len(poses) // MOST_POINTS))
    picked = [*poses[::every], *poses[-1:]][-MOST_POINTS:]
    points = []
    for each in picked:
        place = pose_of(each.get("pose")).after(moved).origin
        points.append(Point(x=_within(place[0]), y=_within(place[1])))
    return tuple(points)


def field_of_view(info: RosValue) -> float:
    """The field of view of a sensor_msgs/CameraInfo, from left to right [rad]; NaN: not known."""
    matrix = info.field("k") if info.field("k") is not None else info.field("K")
    width = int(info.get("width"))
    focal = float(matrix[0]) if matrix is not None and len(matrix) else 0.0
    if not (focal > 0.0 and width > 0):
        return math.nan
    return min(3.1, max(1e-6, 2.0 * math.atan(width / (2.0 * focal))))


def is_touched(value: RosValue) -> bool:
    """Whether a message of a bumper says that it is pressed.

    It is an irobot_create_msgs/HazardDetectionVector, a kobuki_ros_interfaces/BumperEvent or a
    gazebo_msgs/ContactsState.
    """
    hazards, contacts = value.field("detections"), value.field("states")
    if hazards is not None:
        return any(int(each.get("type")) == _BUMP for each in hazards)
    return bool(len(contacts)) if contacts is not None else int(value.get("state")) == 1


def planar(twist: RosValue) -> tuple[float, float, float, float]:
    """Forward, left, up [m/s] and turning [rad/s] of a geometry_msgs/Twist; NaN: not known."""
    linear = _vector(twist.get("linear"), 100.0)
    return (*linear.tolist(), float(_vector(twist.get("angular"), 100.0)[2]))


def _vector(value: RosValue, most: float) -> npt.NDArray[np.float64]:
    """A vector within its limits; NaN: not known."""
    numbers = np.array([float(value.get(part)) for part in "xyz"])
    numbers[~np.isfinite(numbers)] = np.nan
    cut: npt.NDArray[np.float64] = np.clip(numbers, -most, most)
    return cut


def _covariance(value: RosValue, name: str) -> npt.NDArray[np.float64]:
    """A covariance of three axes (9), in a copy.

    Raises:
        RosMessageError: The robot's definition of the message has another length.
    """
    made = np.array(value.get(name), np.float64)
    if made.shape != (9,):
        text = f"{name} has {made.size} numbers, not 9"
        raise RosMessageError(text)
    return made


def _turned(covariance: npt.NDArray[np.float64], mount: FramePlace) -> npt.NDArray[np.float64]:
    """A covariance in the frame of the body (9); one that is not known stays as it is."""
    if not (covariance[0] >= 0.0 and np.isfinite(covariance).all()):
        return covariance
    with np.errstate(over="ignore", invalid="ignore"):  # numbers near the largest one
        turned: npt.NDArray[np.float64] = mount.turn @ covariance.reshape(3, 3) @ mount.turn.T
    return turned.reshape(9)


def known_number(value: RosValue, name: str, least: float, most: float) -> float:
    """A number of a message within its limits; NaN: not known."""
    number = float(value.get(name))
    return number if least <= number <= most else math.nan


def _within(metres: Any) -> float:  # noqa: ANN401 - a number of numpy
    return max(-FARTHEST_M, min(FARTHEST_M, float(metres)))
