"""What a robot file asks of a simulated body that the body or its arena lacks; pure."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hub import toml_reader as toml
from hub.gcm.body import Freedom, HoldKind
from hub.gcm.vehicle import Arming
from hub.robots.description import Base, RobotDescription
from hub.robots.left_alone import LeftAlone
from hub.sim.arena import Arena

NO_WATER = "it has no water to dive in; give it a table [water]"
_HOLDS = {
    Base.BLIMP: (HoldKind.HEIGHT, HoldKind.HEADING),
    Base.ROV: (HoldKind.DEPTH, HoldKind.HEADING),
}
_JOINTS = {Base.TRACKS: 2}
"""Pairs of flippers."""
_LEFT_ALONE = {
    Base.BLIMP: (LeftAlone.STAND, LeftAlone.HOLD_HEIGHT),
    Base.ROV: tuple(LeftAlone),
}
_FREEDOMS = {
    Base.WHEELS: (Freedom.SURGE, Freedom.SWAY, Freedom.YAW),
    Base.BLIMP: (Freedom.SURGE, Freedom.HEAVE, Freedom.YAW),
    Base.ROV: tuple(Freedom),
}
_ON_ROUGH_GROUND = (Freedom.SURGE, Freedom.YAW)
"""Also of tracks on level ground."""
_FLOATS = (Base.BLIMP, Base.ROV)
_NONE = "a simulated body of this kind has none"


def simulation_faults(robot: RobotDescription, arena: Arena) -> Iterator[tuple[str, str, str]]:
    """Table, key and a sentence of each."""
    base = robot.base
    if base is Base.ROV and arena.water is None:
        yield "[simulation]", "arena", NO_WATER
    yield from _motion_faults(robot, arena)
    if base is Base.WHEELS and arena.ground is None and not robot.footprint:
        distances = arena.footprints.distances(arena.start.x, arena.start.y).tolist()
        far, name = min(
            zip(distances, arena.footprints.origin, strict=True), default=(math.inf, "")
        )
        if far < robot.radius:
            yield "[simulation]", "arena", f"the robot would touch {name} at the start"
    if robot.ranges and base in _FLOATS:
        yield toml.repeated("range", 1), "name", _NONE
    for count, table in enumerate(robot.holds, start=1):
        if table.kind not in _HOLDS.get(base, ()):
            yield toml.repeated("hold", count), "kind", _NONE
    if robot.lights:
        yield toml.repeated("light", 1), "name", _NONE
    if len(robot.joints) > _JOINTS.get(base, 0):
        yield toml.repeated("joint", _JOINTS.get(base, 0) + 1), "name", _NONE
    arms = base in _HOLDS or robot.has_autopilot
    if robot.arming is not Arming.NONE and not arms:
        yield "[body]", "arming", "a simulated body of this kind cannot be disarmed"


def _motion_faults(robot: RobotDescription, arena: Arena) -> Iterator[tuple[str, str, str]]:
    base = robot.base
    rough = base is Base.TRACKS or (base is Base.WHEELS and arena.ground is not None)
    freedoms = _ON_ROUGH_GROUND if rough else _FREEDOMS[base]
    for motion in robot.body.motions:
        if motion.freedom not in freedoms:
            where = " on rough ground" if rough and base is Base.WHEELS else ""
            word = motion.freedom.name.lower()
            yield "[limits]", word, f"a simulated body of this kind cannot {word}{where}"
    if robot.left_alone not in _LEFT_ALONE.get(base, (LeftAlone.STAND,)):
        yield "[safety]", "left_alone", "a simulated body of this kind cannot do that"
