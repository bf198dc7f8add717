"""The robot file of a vehicle that was found on a link, and what its owner has to know; pure."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping
from typing import Final

from hub.errors import CameraError
from hub.gcm.autopilot import UnsafeParameter
from hub.plain_text import plain
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.asking.findings import (
    STATION_KIND,
    FoundComponent,
    FoundStream,
    VehicleFinder,
)
from hub.robots.mavlink.asking.silence import unanswered
from hub.robots.mavlink.kinds import AUTOPILOTS, KINDS, firmware_name, kind_name
from hub.robots.mavlink.profiles.ardurover import STEERS
from hub.robots.mavlink.profiles.profile import STATION, Setpoint
from hub.robots.mavlink.profiles.unsafe_parameters import unsafe_parameters
from hub.robots.video_source import SourceKind, video_source
from hub.values import dataclass

_UNKNOWN_SPEED: Final = 0.3
"""Limit of a vehicle that does not say how fast it may be [m/s]."""
_CLIMB: Final = 0.5
"""Highest limit of a copter upwards that is written [m/s]."""
_TURN: Final = 1.0
"""Highest turn rate that is written [rad/s]."""
_FASTEST: Final = 1.0
"""Highest limit that is written; its owner may raise it [m/s]."""
_STICK_US: Final = 400.0
_MOST_ADDRESS: Final = 200
EXTRA: Final = ("ATC_STR_RAT_MAX",)
"""Parameters that only the robot file needs, and that some vehicles do not have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Shape:
    """The usual body of a kind of vehicle.

    Attributes:
        radius: Circle around it [m].
        height: [m].
        alone: What it does without an operator.
    """

    radius: float
    height: float
    alone: LeftAlone = LeftAlone.STAND


_SHAPES: Final[Mapping[str, _Shape]] = {
    "rover": _Shape(radius=0.35, height=0.3),
    "boat": _Shape(radius=0.6, height=0.4),
    "sub": _Shape(radius=0.3, height=0.26, alone=LeftAlone.SURFACE),
    "copter": _Shape(radius=0.4, height=0.3, alone=LeftAlone.HOLD_HEIGHT),
    "blimp": _Shape(radius=0.6, height=0.8, alone=LeftAlone.HOLD_HEIGHT),
}
_ANY_SHAPE: Final = _Shape(radius=0.5, height=0.3)


def limits(finder: VehicleFinder) -> Setpoint:
    """The largest velocities that a vehicle follows with its present parameters.

    A fast one gets less, since its owner has not seen it drive here yet. 0: it cannot.
    """
    profile, values = finder.profile, finder.parameters
    if profile is None:
        return Setpoint()
    match profile.name:
        case "sub":
            gain = values.get("JS_GAIN_DEFAULT", 0.5)
            stick = gain * (1.0 - values.get("THR_DZ", 100.0) / _STICK_US)
            flat = values.get("PILOT_SPEED", 50.0) / 100.0 * stick
            rise = values.get("PILOT_SPEED_UP", 50.0) / 100.0
            sink = values.get("PILOT_SPEED_DN", 0.0) / 100.0 or rise
            made = Setpoint(ahead=flat, left=flat, up=min(rise, sink), turn=_TURN)
        case "blimp":
            flat = values.get("MAX_VEL_XY", _UNKNOWN_SPEED)
            up = values.get("MAX_VEL_Z", _UNKNOWN_SPEED)
            made = Setpoint(ahead=flat, left=flat, up=up, turn=values.get("MAX_VEL_YAW", _TURN))
        case "copter":
            flat = values.get("MPC_VEL_MANUAL", _FASTEST)
            up = min(values.get(f"MPC_Z_VEL_MAX_{way}", _CLIMB) for way in ("UP", "DN"))
            turn = math.radians(values.get("MPC_MAN_Y_MAX", math.inf))
            made = Setpoint(ahead=flat, left=flat, up=min(up, _CLIMB), turn=turn)
        case _:
            named = (values.get(name) for name in ("WP_SPEED", "SPEED_MAX", "RO_SPEED_LIM"))
            fast = next(filter(None, named), _UNKNOWN_SPEED)
            turns = (values.get(name, math.inf) for name in ("ATC_STR_RAT_MAX", "RO_YAW_RATE_LIM"))
            turn = math.radians(min(turns))
            made = Setpoint(ahead=fast, turn=turn)
    return Setpoint(
        ahead=_limit(made.ahead, _FASTEST),
        left=_limit(made.left, _FASTEST),
        up=_limit(made.up, _FASTEST),
        turn=_limit(made.turn, _TURN),
    )


def unsafe(finder: VehicleFinder, station: int) -> list[UnsafeParameter]:
    """Its parameters that are unsafe or were not read, for a ground station of this number."""
    if finder.profile is None:
        return []
    return [*unsafe_parameters(finder.profile, finder.parameters, station)]


def title(finder: VehicleFinder) -> str:
    """What a vehicle is: "rover with ArduPilot 4.7.0"."""
    vehicle = finder.vehicle
    if vehicle is None:
        return "no vehicle"
    autopilot = AUTOPILOTS.get(vehicle.autopilot, f"autopilot {vehicle.autopilot}")
    return f"{kind_name(vehicle.kind)} with {firmware_name(autopilot, finder.firmware)}"


def usual_name(finder: VehicleFinder) -> str:
    """A robot's name for a vehicle."""
    return finder.profile.name if finder.profile is not None else "vehicle"


def remarks(finder: VehicleFinder, *, station: int, signs: bool) -> Iterator[str]:
    """What the owner has to know of a vehicle, a sentence each.

    Args:
        finder: It has asked the vehicle.
        station: Number of the hub as a ground station.
        signs: Whether a key was given.
    """
    vehicle = finder.vehicle
    if vehicle is None:
        return
    if not finder.answers:
        yield unanswered(signed=vehicle.signed, signs=signs)
    elif vehicle.signed and not signs:
        yield "its frames have signatures: give the file of its key"
    yield from _rules(finder)
    if vehicle.armed:
        yield "it is armed now: its motors may move"
    yield from _parameters(finder, station)
    for each in finder.components.values():
        yield from _component(each, vehicle)
    for stream in finder.streams.values():
        if stream.address.startswith(("rtp:", "udp:")):
            yield f"its stream {stream.name!r} has to be sent to this machine: {stream.address}"
        if not _readable(stream):
            address = stream.address or "no address"
            yield f"no pictures can be read from its stream {stream.name!r} at {address}"


def _rules(finder: VehicleFinder) -> Iterator[str]:
    if finder.profile is None:
        yield "Rune does not drive vehicles of this type: it only watches"
    elif not finder.profile.verified:
        yield "its rules follow documents: they were not compared with recordings of such a vehicle"
    if finder.parameters.get("SERVO1_FUNCTION") == STEERS:
        yield "it steers with wheels or a rudder (SERVO1_FUNCTION 26): it cannot turn on the spot"


def _parameters(finder: VehicleFinder, station: int) -> Iterator[str]:
    asked = [name for name in finder.wanted if name not in EXTRA]
    decisive = [each.name for each in unsafe(finder, station)]
    missing = [name for name in asked if name not in (*finder.parameters, *decisive)]
    if missing and finder.answers:
        yield f"it has no parameters of these names, or did not answer: {', '.join(missing)}"
    for each in unsafe(finder, station):
        yield unsafe_words(each)


def unsafe_words(each: UnsafeParameter) -> str:
    """An unsafe parameter, or one that was not read, with the reason."""
    if math.isnan(each.value):
        return f"not known: {each.name} was not read, and it has to be {each.wanted:g}: {each.why}"
    return f"unsafe: {each.name} is {each.value:.6g} in place of {each.wanted:g}: {each.why}"


def _component(each: FoundComponent, vehicle: FoundComponent) -> Iterator[str]:
    """What counts of another sender of heartbeats."""
    if each.is_vehicle and each.system != vehicle.system:
        yield f"another vehicle is on this link: system {each.system}, {kind_name(each.kind)}"
    elif each.kind == STATION_KIND:
        yield f"a ground station is connected to it: system {each.system}"
    elif each.component != vehicle.component:
        unknown = "" if each.kind in KINDS else ", which is not understood"
        yield f"it has a component {each.component}: {kind_name(each.kind)}{unknown}"


def robot_file(
    finder: VehicleFinder,
    address: str,
    *,
    name: str = "",
    key_file: str = "",
    station: int = STATION,
    today: str = "",
) -> str:
    """The text of a robot file for the vehicle that was asked.

    Args:
        finder: It has asked a vehicle.
        address: Where the vehicle is.
        name: The robot's name; empty: the name of its kind.
        key_file: File of the signing key; empty: none.
        station: Number of the hub as a ground station.
        today: The date, for the first line; empty: none.
    """
    system = finder.vehicle.system if finder.vehicle is not None else 0
    shape = _SHAPES.get(finder.profile.name if finder.profile else "", _ANY_SHAPE)
    most = limits(finder)
    when = f" on {today}" if today else ""
    lines = [
        f"# A {title(finder)}, adopted{when}.",
        f"name = {_text(name or usual_name(finder))}",
        'kind = "mavlink"',
        "",
        "[mavlink]",
        f"address = {_text(address)}",
        f"system = {system}",
    ]
    if finder.profile is not None:
        lines.append(f"vehicle = {_text(finder.profile.name)}    # no other kind is driven")
    lines += [f"station = {station}"] if station != STATION else []
    lines += [f"key_file = {_text(key_file)}"] if key_file else []
    lines += ["", "[limits]", *_limit_lines(most)]
    lines += [
        "",
        "[body]",
        f"radius = {shape.radius:<10g}# usual for its kind: measure the circle that encloses it",
        f"height = {shape.height:g}",
        'arming = "disarmed"     # Rune arms it only when its operator says so',
        "",
        "[safety]",
        f"left_alone = {_text(shape.alone.value)}",
        "",
        *_camera(finder),
        *_modules(camera=any(map(_readable, finder.streams.values()))),
    ]
    return "\n".join(lines) + "\n"


def _limit_lines(most: Setpoint) -> Iterator[str]:
    yield f"linear = {most.ahead:<10g}# [m/s]"
    if most.left:
        yield f"sway = {most.left:g}"
    if most.up:
        yield f"heave = {most.up:g}"
    yield f"angular = {most.turn:<9g}# [rad/s]"


def _camera(finder: VehicleFinder) -> Iterator[str]:
    """The first stream that can be read, or an example of one."""
    streams = [each for each in finder.streams.values() if _readable(each)]
    if streams:
        yield "[camera]"
        yield f"source = {_text(streams[0].address)}"
        yield "fov_deg = 80"
    else:
        yield "# [camera]"
        yield '# source = "rtsp://192.168.2.2:8554/video"   # the address of its video, or a device'
        yield "# fov_deg = 80"
    yield ""


def _modules(*, camera: bool) -> Iterator[str]:
    for module in ("driver", "navigation", "mapping"):
        yield f"[modules.{module}]"
        yield f'run = "hub.modules.{module}"'
        yield ""
    off = "" if camera else "# "
    yield f"{off}[modules.vision]"
    yield f'{off}run = "hub.modules.vision"'
    yield ""
    yield "[modules.recorder]"
    yield 'run = "hub.modules.recorder"'
    yield 'start = "on demand"'
    yield 'capabilities = ["REC_LOG"]'


def _readable(stream: FoundStream) -> bool:
    """Whether the vision module can read a stream."""
    if not 0 < len(stream.address) <= _MOST_ADDRESS:
        return False
    with contextlib.suppress(CameraError):
        return video_source(stream.address).kind is SourceKind.STREAM
    return False


def _limit(value: float, most: float) -> float:
    """A limit as it is written: within 0 and `most`, rounded down to 0.01."""
    if not math.isfinite(value):
        return most
    return math.floor(100.0 * max(0.0, min(most, value)) + 1e-3) / 100.0


def _text(value: str) -> str:
    """A text as TOML has it."""
    shown = plain(value).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{shown}"'
