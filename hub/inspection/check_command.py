"""`rune-hub check`: what a robot file says of its robot, or all its mistakes."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hub.command_output import put, put_json
from hub.gcm.body import BodyFrame, CameraBody, HoldKind, RobotBody
from hub.inspection import value_text
from hub.inspection.output import table
from hub.robots.description import RobotDescription
from hub.robots.fleet_table import FleetTable
from hub.robots.registry import body_of


def check(robot: RobotDescription, *, as_json: bool) -> int:
    """Show the robot of a file without mistakes; returns the exit code."""
    body = body_of(robot)
    if as_json:
        shown = value_text.plain(body)
        if robot.fleet is not None:
            shown["fleet"] = {"name": robot.fleet.name or robot.name, "words": _fleet(robot.fleet)}
        put_json(shown)
        return 0
    put(f"{robot.path}: no mistakes")
    rows = [*_rows(body)]
    if robot.fleet is not None:
        rows.append(("fleet", robot.fleet.name or robot.name, _fleet(robot.fleet)))
    table(("part", "of", "described as"), rows, words=3)
    return 0


def _fleet(joined: FleetTable) -> str:
    shows = f"certificate in {joined.certificates}" if joined.certificates else "no certificate"
    thin = f"thin states {joined.thin_hz:g} times a second"
    return f"in {joined.fleet} at {joined.place}, {shows}, {thin}"


def _rows(body: RobotBody) -> Iterator[tuple[str, str, str]]:
    """Part of the robot, its name, and its figures in words."""
    outline = f"{len(body.footprint)} corners" if body.footprint else "round"
    high = "" if math.isnan(body.height) else f", {body.height:g} m high"
    heavy = "" if math.isnan(body.mass) else f", {body.mass:g} kg"
    yield "body", body.kind, f"{outline}, within {body.radius:.3g} m{high}{heavy}"
    for motion in body.motions:
        unit = "m/s" if motion.freedom < 3 else "rad/s"
        words = f"up to {motion.limit:g} {unit}, changes by {motion.acceleration:g} {unit}^2"
        yield "motion", motion.freedom.name.lower(), words
    frames = {frame.name: frame for frame in body.frames}
    for sensors in body.ranges:
        beams = f"{sensors.beams} beams, " if sensors.beams > 1 else ""
        kind = sensors.kind.name.lower().replace("_", " ")
        reach = f"{sensors.nearest:g} to {sensors.farthest:g} m, {sensors.rate_hz:g} Hz"
        yield "range", sensors.name, f"{kind}, {beams}{reach}, {_place(frames[sensors.name])}"
    for bumper in body.bumpers:
        words = f"at {math.degrees(bumper.direction):.4g} degrees, {_degrees(bumper.width)} wide"
        yield "bumper", bumper.name, words
    for camera in body.cameras:
        words = f"{_degrees(camera.horizontal_fov)} from left to right, {_head(camera)}"
        yield "camera", camera.name, f"{words}, {_place(frames[camera.name])}"
    yield from _vehicle_rows(body)
    yield "left alone", "", body.left_alone
    for each in body.messages:
        yield "message", each.message, each.part


def _head(camera: CameraBody) -> str:
    parts = []
    if camera.pan_limit:
        parts.append(f"pans {_degrees(camera.pan_limit)} to each side")
    if camera.tilt_lowest < camera.tilt_highest:
        lowest, highest = math.degrees(camera.tilt_lowest), math.degrees(camera.tilt_highest)
        parts.append(f"tilts from {lowest:.4g} to {highest:.4g} degrees")
    if camera.zoom > 1.0:
        parts.append(f"zooms {camera.zoom:g} times")
    return ", ".join(parts) or "fixed"


def _vehicle_rows(body: RobotBody) -> Iterator[tuple[str, str, str]]:
    for hold in body.holds:
        heading = hold.kind is HoldKind.HEADING
        off = _degrees(hold.tolerance) if heading else f"{hold.tolerance:g} m"
        yield "hold", hold.kind.name.lower(), f"fails when more than {off} off"
    for light in body.lights:
        yield "light", light.name, f"of the camera {light.camera!r}" if light.camera else ""
    for joint in body.joints:
        limits = f"{_degrees(joint.lowest)} to {_degrees(joint.highest)}"
        yield "joint", joint.name, f"{limits}, {_degrees(joint.speed)} per second"
    if body.arms:
        yield "motors", "", "can be disarmed"


def _place(frame: BodyFrame) -> str:
    place = f"at [{frame.x:g}, {frame.y:g}, {frame.z:g}] m of {frame.parent}"
    turned = [
        f"{name} {_degrees(angle)}"
        for name, angle in (("roll", frame.roll), ("pitch", frame.pitch), ("yaw", frame.yaw))
        if angle
    ]
    return ", ".join((place, *turned))


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.4g} degrees"
