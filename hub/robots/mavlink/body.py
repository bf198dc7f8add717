"""A vehicle with an autopilot as the body of a robot."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from hub.gcm.autopilot import (
    AutopilotPhase,
    AutopilotState,
    AutopilotText,
    MavlinkFrames,
    UnsafeParameter,
)
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.joints import JointState
from hub.gcm.navigation import GroundTruth
from hub.gcm.ranges import scan_of
from hub.gcm.vehicle import Arming, LightState, VehicleState
from hub.robots.description import RobotDescription
from hub.robots.interfaces import FileLoop, Sensors
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.forwarding import passable
from hub.robots.mavlink.kinds import firmware_name
from hub.robots.mavlink.link.address import vehicle_address
from hub.robots.mavlink.link.answer_watch import AnswerWatch
from hub.robots.mavlink.link.byte_link import MOST_READ, ByteLink
from hub.robots.mavlink.link.opening import link_to
from hub.robots.mavlink.link.tap import LinkTap
from hub.robots.mavlink.link.vehicle_claim import VehicleClaim
from hub.robots.mavlink.problems import other_kind_words, rival_words, vehicle_problems
from hub.robots.mavlink.profiles.profile import NEUTRAL, Setpoint
from hub.robots.mavlink.profiles.stop_times import stop_times
from hub.robots.mavlink.profiles.unsafe_parameters import unsafe_parameters
from hub.robots.mavlink.ranges import ranges_of
from hub.robots.mavlink.reckoning import VehicleReckoning
from hub.robots.mavlink.vehicle.other_stations import STATION_COMPONENT
from hub.robots.mavlink.vehicle.reasons import why
from hub.robots.mavlink.vehicle.vehicle import MavlinkVehicle
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from hub.robots.mavlink.wire.signing_key import read_signing_key

_NOT_KNOWN: Final = (AutopilotPhase.LINKING, AutopilotPhase.LEARNING, AutopilotPhase.GONE)
"""Phases in which a place that the vehicle knows may be missing."""
_CLAIM_S: Final = 0.5
"""Time between two attempts to claim the vehicle [s]."""
_WORDS: Final = {
    AutopilotPhase.LINKING: "links",
    AutopilotPhase.LEARNING: "learns",
    AutopilotPhase.ARMING: "arms",
    AutopilotPhase.GONE: "gone",
}


class MavlinkBody:
    """Implements `Body`, `BodyArms`, `BodyModes`, `BodyWakes` and `BodyLeftAlone`.

    Its lights and its joint, `BodyLights` and `BodyJoints`, are those of a Sub and its camera: the
    first light of the robot file is the vehicle's Lights1, the second its Lights2.
    Where the vehicle does not know its place, the dead reckoning adds up the commanded velocity.
    """

    def __init__(
        self, robot: RobotDescription, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Open the link; nothing is sent before the first `advance`.

        Args:
            robot: The robot file.
            clock: The monotonic clock [s].

        Raises:
            VehicleAddressError: The robot file has no address of a vehicle.
            KeyFileError: Its signing key cannot be used.
        """
        self._clock, self._robot = clock, robot
        self._address = vehicle_address(robot.vehicle_address)
        self._link: ByteLink = link_to(self._address)
        self._claim: VehicleClaim | None = None
        self._rival = ""
        self._claimed_at = -math.inf
        signer = _signer(robot.signing_key)
        self._parser = FrameParser(signer)
        self._station = robot.vehicle_station
        limits = Setpoint(
            ahead=robot.linear_limit,
            left=robot.sway_limit,
            up=robot.heave_limit,
            turn=robot.angular_limit,
        )
        self.vehicle = MavlinkVehicle(
            self._send,
            FramePacker(self._station, STATION_COMPONENT, signer),
            limits,
            robot.vehicle_system,
        )
        self._tap = LinkTap()
        self._peers = 0
        self._answers: AnswerWatch | None = None
        self._reckoning = VehicleReckoning()
        self._left_alone = robot.left_alone

    def command(self, twist: Twist) -> None:
        """Follow a velocity; one that the vehicle cannot have is left out."""
        wanted = Setpoint(
            ahead=twist.linear.x, left=twist.linear.y, up=twist.linear.z, turn=twist.angular.z
        )
        self.vehicle.set_velocity(NEUTRAL if self._other_kind else wanted, self._clock())

    def advance(self, seconds: float) -> None:
        """Read the link, and send what is due."""
        self._listen()
        self._reckon(seconds)

    def wake_by(self, loop: FileLoop, report: Callable[[], bool]) -> None:
        """Read the link also when an answer comes; it has measured nothing by that."""
        del report
        self._answers = AnswerWatch(loop, self._link, self._listen)

    def arm(self, *, armed: bool) -> None:
        """Ask the vehicle to arm or to disarm."""
        if not armed:
            self.vehicle.disarm(self._clock())
        elif not self._other_kind:
            self.vehicle.arm(self._clock())

    def drive(self) -> None:
        """Ask for the mode that follows velocities."""
        self.vehicle.drive(self._clock())

    def stay(self) -> None:
        """Ask for the mode in which it stays."""
        self.vehicle.stay(self._clock())

    def set_mode(self, name: str) -> None:
        """Ask for a mode by its name."""
        self.vehicle.set_mode(name, self._clock())

    def left_alone(self, action: LeftAlone | None) -> None:
        """Ask for the mode of this action."""
        self.vehicle.left_alone(action, self._clock())

    def set_light(self, name: str, brightness: float) -> None:
        """Set the brightness of a light, step by step."""
        names = [each.name for each in self._robot.lights]
        self.vehicle.lights.set(names.index(name) + 1, brightness, self._clock())

    def turn_joint(self, name: str, rate: float) -> None:
        """Turn the camera up or down [rad/s]."""
        joint = next(each for each in self._robot.joints if each.name == name)
        self.vehicle.tilt.turn(rate, joint.lowest, joint.highest, self._clock())

    def ground_truth(self) -> GroundTruth | None:
        """Not known."""
        return None

    def sensors(self, stamp: float) -> Sensors:
        """The present measurements."""
        groups = (table.sensors for table in self._robot.ranges)
        vehicle, read = self.vehicle, self.vehicle.telemetry
        pose, commanded = self._reckoning.pose, self._commanded
        gone = vehicle.phase in (AutopilotPhase.LINKING, AutopilotPhase.GONE)
        afloat = vehicle.profile is not None and "up" in vehicle.profile.frees
        problems = vehicle_problems(
            vehicle,
            self._link.state,
            self._clock(),
            rival=self._rival,
            other_kind=self._other_kind,
            stops_after_cut=self._stops()[1],
            left_alone=self._left_alone,
        )
        under_water = vehicle.profile is not None and vehicle.profile.name == "sub"
        return Sensors(
            known=self._reckoning.number > 0 and not gone,
            x=pose.x,
            y=pose.y,
            z=_or_zero(read.z if math.isfinite(read.z) else -read.depth) if afloat else 0.0,
            theta=pose.theta,
            velocity=_known(read.velocity, commanded, place=self._reckoning.has_place),
            scans=tuple(
                scan_of(group, ranges_of(group, read, self._clock()), stamp) for group in groups
            ),
            joints=tuple(
                JointState(name=each.name, position=read.tilt) for each in self._robot.joints
            ),
            commanded=commanded,
            battery_voltage=read.voltage,
            battery_fraction=read.charge,
            roll=read.roll,
            pitch=read.pitch,
            heading=read.yaw,
            height=read.z if afloat and not under_water else math.nan,
            above_ground=read.below if afloat else math.nan,
            depth=read.depth if under_water else math.nan,
            turning=read.rates if _is_measured(read.rates) else None,
            pressure=read.pressure,
            climb=read.climb if afloat else math.nan,
            reckoning=self._reckoning.number,
            slow=True,
            diagnostics=tuple(problems),
            vehicle=VehicleState(
                activity=_WORDS.get(vehicle.phase, ""),
                arming=Arming.ARMED if vehicle.armed else Arming.DISARMED,
                lights=tuple(
                    LightState(name=each.name, brightness=_or_zero(read.brightness(number)))
                    for number, each in enumerate(self._robot.lights, 1)
                ),
            ),
        )

    def autopilot(self, stamp: float) -> AutopilotState:
        """The present state of the autopilot."""
        vehicle, profile, now = self.vehicle, self.vehicle.profile, self._clock()
        stops = self._stops()
        heard = now - vehicle.liveness.heard
        return AutopilotState(
            stamp=stamp,
            phase=vehicle.phase,
            why=rival_words(self._rival) or self._other_kind or why(vehicle, now),
            vehicle=profile.name if profile is not None else "",
            firmware=firmware_name(profile.autopilot if profile else "", vehicle.heard.firmware),
            verified=int(profile is not None and profile.verified),
            mode=profile.mode_name(vehicle.mode) if profile and vehicle.mode >= 0 else "",
            modes=tuple(profile.modes[each] for each in profile.offered) if profile else (),
            holds=profile.mode_name(profile.holds) if profile and profile.holds is not None else "",
            refusal=vehicle.orders.refusal(),
            armable=int(vehicle.telemetry.armable),
            failsafe=int(vehicle.failsafe),
            heard_s=heard if math.isfinite(heard) else math.nan,
            round_trip_s=vehicle.liveness.round_trip,
            lost=vehicle.liveness.lost(now),
            position=int(vehicle.telemetry.position),
            satellites=vehicle.telemetry.satellites,
            gain=vehicle.telemetry.gain,
            stops_after_zero_s=stops[0],
            stops_after_cut_s=stops[1],
            unsafe=tuple(self._unsafe()),
        )

    def take_texts(self) -> tuple[AutopilotText, ...]:
        """The texts of the vehicle since the last call."""
        stamp, now = time.time(), self._clock()
        return tuple(
            AutopilotText(stamp=stamp - (now - each.time), level=each.level, text=each.text)
            for each in self.vehicle.texts.take()
        )

    def take_frames(self, *, wanted: bool) -> tuple[MavlinkFrames, ...]:
        """The bytes of the link since the last call; `wanted`: keep those from now on."""
        return self._tap.take(wanted=wanted)

    def pass_on(self, frames: bytes) -> None:
        """Send frames of another ground station, unless they drive or keep alive.

        With a signing key nothing is sent: those frames have no signature of it.
        """
        if not self.vehicle.signs:
            for frame in passable(frames, self.vehicle.system):
                if frame.name.startswith("COMMAND"):
                    self.vehicle.stations.commanded(frame["command"])
                self._send(frame.raw)

    def close(self) -> None:
        """Release the link."""
        self._link.close()
        if self._claim is not None:
            self._claim.close()

    @property
    def _other_kind(self) -> str:
        return other_kind_words(self._robot.vehicle_kind, self.vehicle)

    def _listen(self) -> None:
        """Read the link, and send what is due."""
        now = self._clock()
        find = self._parser.datagram if self._link.datagrams else self._parser.feed
        openings = self._link.state.openings
        pieces = self._link.read(now)
        if self._link.state.openings != openings:
            self.vehicle.stop_driving(now)  # however short the gap was
        if self._link.peers != self._peers:
            self._peers = self._link.peers
            self.vehicle.another_sender(now)
        self._tap.came(pieces)
        flooded = sum(map(len, pieces)) >= MOST_READ
        for piece in pieces:
            for frame in find(piece):
                self.vehicle.received(frame, now)
        self.vehicle.heard.refused = self._parser.refused
        if self.vehicle.system:
            self._take_claim(now)
        self.vehicle.step(now)
        if self._answers is not None:
            self._answers.follow(awaits=not flooded and self.vehicle.awaits(now))

    def _take_claim(self, now: float) -> None:
        """Claim the vehicle; while another process has it, nothing is sent, so it is GONE."""
        if self._claim is None:
            self._claim = VehicleClaim(self._address, self.vehicle.system)
        if now - self._claimed_at >= _CLAIM_S:
            self._claimed_at = now
            self._rival = "" if self._claim.take() else self._rival or self._claim.owner()

    def _send(self, frame: bytes) -> None:
        if not self._rival and self._link.write(frame):
            self._tap.sent(frame)

    @property
    def _commanded(self) -> Twist:
        wanted = self.vehicle.velocity
        return Twist(
            linear=Vector3(x=wanted.ahead, y=wanted.left, z=wanted.up),
            angular=Vector3(z=wanted.turn),
        )

    def _reckon(self, seconds: float) -> None:
        begun = self._reckoning.number or self.vehicle.phase not in _NOT_KNOWN
        if begun:
            read, wanted = self.vehicle.telemetry, self.vehicle.velocity
            self._reckoning.update(read, wanted, seconds, self._clock())

    def _stops(self) -> tuple[float, float]:
        """Times until it stands: after a zero, and after a cut [s]; NaN: not known."""
        vehicle, values = self.vehicle, self.vehicle.parameters.values
        if vehicle.profile is None:
            return math.nan, math.nan
        return stop_times(vehicle.profile, values, self._robot, receiver=vehicle.telemetry.receiver)

    def _unsafe(self) -> Iterator[UnsafeParameter]:
        """Its unsafe parameters; those that were not read too, once all was asked for."""
        profile, reads = self.vehicle.profile, self.vehicle.parameters
        known = unsafe_parameters(profile, reads.values, self._station) if profile else ()
        return (each for each in known if not (reads.reading and math.isnan(each.value)))


def _signer(path: str) -> Signer | None:
    """Signs with the key in a file; None: the robot file names none."""
    if not path:
        return None
    clock = SigningClock(Path(f"{path}.stamp"))
    return Signer(read_signing_key(Path(path)), clock)


def _or_zero(value: float) -> float:
    return value if math.isfinite(value) else 0.0


def _is_measured(vector: Vector3) -> bool:
    return all(map(math.isfinite, (vector.x, vector.y, vector.z)))


def _known(measured: Twist, commanded: Twist, *, place: bool) -> Twist:
    """The measured velocity; what is not measured, or old, is as commanded."""
    linear = measured.linear if place else Vector3(x=math.nan, y=math.nan, z=math.nan)
    return Twist(
        linear=_filled(linear, commanded.linear),
        angular=_filled(measured.angular, commanded.angular),
    )


def _filled(one: Vector3, other: Vector3) -> Vector3:
    """A vector; where a part of it is no number, that of the other."""
    x, y, z = (
        part if math.isfinite(part) else instead
        for part, instead in ((one.x, other.x), (one.y, other.y), (one.z, other.z))
    )
    return Vector3(x=x, y=y, z=z)
