"""What a vehicle measures, in Rune's frames: ENU and FLU; pure.

| MAVLink | Rune |
| --- | --- |
| north, east, down | y, x, -z of `odom` |
| yaw, clockwise from north | theta = pi/2 - yaw, counter-clockwise from east |
| pitch, positive nose up | -pitch, positive nose down |
| roll, positive right side down | roll |

Values that do not come, come no more, or are not numbers, are NaN. The origin of `odom` is that of
the vehicle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from hub.gcm.geometry import Twist, Vector3
from hub.robots.mavlink.wire.frames import MavlinkFrame
from hub.values import dataclass

_PREARM: Final = 0x10000000
"""MAV_SYS_STATUS_PREARM_CHECK."""
_IN_AIR: Final = 2
"""MAV_LANDED_STATE_IN_AIR."""
_POSITION: Final = 16
"""Flag of EKF_STATUS_REPORT and ESTIMATOR_STATUS: it knows its place in the horizontal plane."""
_NO_VOLTAGE: Final = 65535
_FARTHEST: Final = 1e6
_FASTEST: Final = 100.0
_AHEAD: Final = 0
_DOWN: Final = 25
"""MAV_SENSOR_ORIENTATION of range sensors."""
_BODY_FRD: Final = 12
"""MAV_FRAME_BODY_FRD: directions from ahead."""
_NOTHING_MEASURED: Final = 65535
_INVALID: Final = 1
"""Value of DISTANCE_SENSOR.signal_quality: the sensor knows that it measured nothing."""
_NO_RATES: Final = Vector3(x=math.nan, y=math.nan, z=math.nan)
_STILL: Final = 0.05
"""Speed below which it stands [m/s]."""
_RECENT_S: Final = 0.5


def within(value: float, most: float) -> float:
    """A number; NaN where it is none, or larger than any vehicle's."""
    return value if abs(value) <= most else math.nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Obstacles:
    """The newest OBSTACLE_DISTANCE.

    Attributes:
        first: Direction of the first distance in `base_link`, counter-clockwise from ahead [rad].
        step: From a direction to the next [rad]; negative: clockwise.
        distances: [m]; inf: nothing within reach, -inf: nearer than can be measured, NaN: not
            measured.
    """

    first: float
    step: float
    distances: tuple[float, ...]


def share(value: float) -> float:
    """A part of a whole, 0 to 1; NaN where it is none."""
    return value if 0.0 <= value <= 1.0 else math.nan


class Telemetry:
    """The newest values of one vehicle.

    Attributes:
        x: Position in `odom` [m]; NaN: not known.
        y: Position in `odom` [m].
        z: Height in `odom` [m]; of a vehicle under water, minus its depth.
        yaw: Heading in `odom`, counter-clockwise from x [rad].
        roll: [rad], positive right side down.
        pitch: [rad], positive nose down.
        rates: Turn rates in `base_link` [rad/s].
        east: Velocity in `odom` [m/s].
        north: Velocity in `odom` [m/s].
        climb: Velocity upwards [m/s].
        voltage: Of the battery [V].
        charge: Charge left, 0 to 1.
        armable: Whether its checks before arming succeed.
        receiver: Whether it has a radio receiver; None: not known.
        position: Whether it knows its place.
        satellites: That it sees; 255: not known.
        gain: Share of the sticks' effect that a Sub uses; NaN: not known.
        depth: Below the surface [m].
        pressure: Of the water or air outside [Pa].
        ahead: Range of a sensor ahead [m], as `Obstacles.distances`.
        below: Range of a sensor downwards [m]; NaN: not known.
        in_air: Whether it says that it is in the air.
        tilt: Of its camera [rad], positive up; NaN: not known.
        obstacles: Distances around it; None: none came.
        ahead_at: Monotonic time of the last range ahead [s].
        obstacles_at: Monotonic time of the last distances around it [s].
        named: Newest values of NAMED_VALUE_FLOAT, by name.
        measured: Monotonic time of the last ATTITUDE [s].
        placed: Monotonic time of the last position [s].
        silent: Names of messages that came, and come no more.
        origin: Latitude and longitude [1e-7 deg] and altitude [mm] of the origin; None: not known.
    """

    def __init__(self) -> None:
        self.x = self.y = self.z = math.nan
        self.yaw = self.roll = self.pitch = math.nan
        self.rates = Vector3()
        self.east = self.north = self.climb = math.nan
        self.voltage = self.charge = math.nan
        self.armable = self.position = False
        self.receiver: bool | None = None
        self.satellites = 255
        self.gain = math.nan
        self.depth = self.pressure = math.nan
        self.ahead = self.below = math.nan
        self.in_air = False
        self.tilt = math.nan
        self.obstacles: Obstacles | None = None
        self.named: dict[str, float] = {}
        self.measured = self.placed = self.ahead_at = self.obstacles_at = -math.inf
        self.origin: tuple[int, int, int] | None = None
        self._came: dict[str, float] = {}
        self.silent: set[str] = set()

    def brightness(self, number: int) -> float:
        """Of its light 1 or 2, 0 to 1; NaN: not known."""
        return share(self.named.get(f"Lights{number}", math.nan))

    @property
    def velocity(self) -> Twist:
        """In `base_link`; NaN where it is not known."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Twist(
            linear=Vector3(
                x=self.east * cos + self.north * sin,
                y=self.north * cos - self.east * sin,
                z=self.climb,
            ),
            angular=self.rates,
        )

    def moves(self, now: float) -> bool:
        """Whether a velocity that came a short while ago shows that it moves in the plane."""
        return now - self.placed < _RECENT_S and math.hypot(self.east, self.north) >= _STILL

    def take(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the vehicle's autopilot; one of another message changes nothing."""
        reader = _READERS.get(frame.name)
        if reader is not None:
            reader(self, frame.fields)
            self._came[frame.name] = now
            self.silent.discard(frame.name)
            match frame.name:
                case "ATTITUDE":
                    self.measured = now
                case "LOCAL_POSITION_NED":
                    self.placed = now
                case "DISTANCE_SENSOR" if frame["orientation"] == _AHEAD:
                    self.ahead_at = now
                case "OBSTACLE_DISTANCE":
                    self.obstacles_at = now

    def step(self, now: float) -> None:
        """Forget the values of messages that come no more; monotonic time [s]."""
        for name, (lasting, values) in _LASTING.items():
            if now - self._came.get(name, now) > lasting:
                del self._came[name]
                self.silent.add(name)
                for value, unknown in values.items():
                    setattr(self, value, unknown)


def _attitude(to: Telemetry, values: Mapping[str, Any]) -> None:
    yaw, pitch = within(values["yaw"], math.tau), within(values["pitch"], math.tau)
    to.yaw = math.remainder(math.pi / 2 - yaw, math.tau) if not math.isnan(yaw) else math.nan
    to.roll, to.pitch = within(values["roll"], math.tau), -pitch
    rates = (values["rollspeed"], -values["pitchspeed"], -values["yawspeed"])
    x, y, z = (within(rate, _FASTEST) for rate in rates)
    to.rates = Vector3(x=x, y=y, z=z)


def _local_position(to: Telemetry, values: Mapping[str, Any]) -> None:
    to.x, to.y = within(values["y"], _FARTHEST), within(values["x"], _FARTHEST)
    to.z = -within(values["z"], _FARTHEST)
    to.east, to.north = within(values["vy"], _FASTEST), within(values["vx"], _FASTEST)
    to.climb = -within(values["vz"], _FASTEST)


def _origin(to: Telemetry, values: Mapping[str, Any]) -> None:
    to.origin = values["latitude"], values["longitude"], values["altitude"]


def _status(to: Telemetry, values: Mapping[str, Any]) -> None:
    voltage, left = values["voltage_battery"], values["battery_remaining"]
    to.voltage = voltage / 1e3 if voltage not in (0, _NO_VOLTAGE) else math.nan
    to.charge = left / 100.0 if 0 <= left <= 100 else math.nan
    to.armable = bool(values["onboard_control_sensors_health"] & _PREARM)


def _estimator(to: Telemetry, values: Mapping[str, Any]) -> None:
    to.position = bool(values["flags"] & _POSITION)


def _satellites(to: Telemetry, values: Mapping[str, Any]) -> None:
    to.satellites = values["satellites_visible"]


def _channels(to: Telemetry, values: Mapping[str, Any]) -> None:
    # SYS_STATUS has a sound receiver also where sticks come over MAVLink alone.
    to.receiver = values["chancount"] > 0


def _hud(to: Telemetry, values: Mapping[str, Any]) -> None:
    to.depth = -within(values["alt"], _FARTHEST)


def _pressure(to: Telemetry, values: Mapping[str, Any]) -> None:
    pressure = within(values["press_abs"] * 100.0, 1e9)
    to.pressure = pressure if pressure >= 0.0 else math.nan


def _named(to: Telemetry, values: Mapping[str, Any]) -> None:
    name, value = values["name"], within(values["value"], 1e9)
    if name in to.named or len(to.named) < 64:
        to.named[name] = value
    if name.startswith("PilotGain"):
        to.gain = share(value)


def _range(to: Telemetry, values: Mapping[str, Any]) -> None:
    nearest, farthest = values["min_distance"], values["max_distance"]
    distance = _distance(values["current_distance"], nearest, farthest or _NOTHING_MEASURED)
    if values["signal_quality"] == _INVALID:
        distance = math.nan
    if values["orientation"] == _AHEAD:
        to.ahead = distance
    elif values["orientation"] == _DOWN:
        to.below = distance if math.isfinite(distance) else math.nan


def _landed(to: Telemetry, values: Mapping[str, Any]) -> None:
    to.in_air = values["landed_state"] == _IN_AIR


def _gimbal(to: Telemetry, values: Mapping[str, Any]) -> None:
    """The camera's pitch, from the quaternion of its attitude in north, east, down."""
    w, x, y, z = (within(part, 2.0) for part in values["q"])
    sine = 2.0 * (w * y - z * x)
    to.tilt = math.asin(max(-1.0, min(1.0, sine))) if not math.isnan(sine) else math.nan


def _obstacles(to: Telemetry, values: Mapping[str, Any]) -> None:
    """Distances clockwise from ahead; of a message in another frame, from north, none are taken."""
    step = values["increment_f"] or float(values["increment"])
    step, offset = within(step, 360.0), within(values["angle_offset"], 360.0)
    if values["frame"] != _BODY_FRD or math.isnan(step + offset) or not step:
        return
    limits = values["min_distance"], values["max_distance"]
    distances = values["distances"]
    count = min(len(distances), int(360.0 / abs(step)) or 1)
    to.obstacles = Obstacles(
        first=math.radians(-offset),
        step=math.radians(-step),
        distances=tuple(_distance(each, *limits) for each in distances[:count]),
    )


def _distance(centimetres: int, nearest: int, farthest: int) -> float:
    """A distance [m]; a 0 means that the obstacle touches the sensor."""
    if centimetres == _NOTHING_MEASURED:
        return math.nan
    if centimetres < max(nearest, 1):
        return -math.inf
    return centimetres / 100.0 if centimetres <= farthest else math.inf


_READERS: Final[Mapping[str, Callable[[Telemetry, Mapping[str, Any]], None]]] = {
    "ATTITUDE": _attitude,
    "LOCAL_POSITION_NED": _local_position,
    "GPS_GLOBAL_ORIGIN": _origin,
    "SYS_STATUS": _status,
    "EKF_STATUS_REPORT": _estimator,
    "ESTIMATOR_STATUS": _estimator,
    "EXTENDED_SYS_STATE": _landed,
    "GIMBAL_DEVICE_ATTITUDE_STATUS": _gimbal,
    "OBSTACLE_DISTANCE": _obstacles,
    "GPS_RAW_INT": _satellites,
    "RC_CHANNELS": _channels,
    "VFR_HUD": _hud,
    "SCALED_PRESSURE2": _pressure,
    "NAMED_VALUE_FLOAT": _named,
    "DISTANCE_SENSOR": _range,
}
_LASTING: Final[Mapping[str, tuple[float, Mapping[str, object]]]] = {
    "ATTITUDE": (
        1.5,
        {"yaw": math.nan, "roll": math.nan, "pitch": math.nan, "rates": _NO_RATES},
    ),
    "LOCAL_POSITION_NED": (
        1.5,
        dict.fromkeys(("x", "y", "z", "east", "north", "climb"), math.nan),
    ),
    "SYS_STATUS": (5.0, {"voltage": math.nan, "charge": math.nan, "armable": False}),
    "EKF_STATUS_REPORT": (5.0, {"position": False}),
    "ESTIMATOR_STATUS": (5.0, {"position": False}),
    "EXTENDED_SYS_STATE": (5.0, {"in_air": False}),
    "GPS_RAW_INT": (10.0, {"satellites": 255}),
    "VFR_HUD": (5.0, {"depth": math.nan}),
    "SCALED_PRESSURE2": (5.0, {"pressure": math.nan}),
    "DISTANCE_SENSOR": (5.0, {"ahead": math.nan, "below": math.nan}),
    "GIMBAL_DEVICE_ATTITUDE_STATUS": (5.0, {"tilt": math.nan}),
}
"""How long the values of a message last [s], and those of a vehicle that does not send it.

A vehicle may refuse a rate, and send a message once a second.
"""
