"""What a robot file asks of a simulated body that the body or its arena lacks; pure."""

from __future__ import annotations

from collections.abc import Iterator

from hub import toml_reader as toml
from hub.gcm.body import HoldKind
from hub.gcm.vehicle import Arming
from hub.robots.description import Base, RobotDescription
from hub.sim.arena import Arena

NO_WATER = "it has no water to dive in; give it a table [water]"
_HOLDS = {
    Base.BLIMP: (HoldKind.HEIGHT, HoldKind.HEADING),
    Base.ROV: (HoldKind.DEPTH, HoldKind.HEADING),
}
_JOINTS = {Base.TRACKS: 2}
"""Pairs of flippers."""
_NONE = "a simulated body of this kind has none"


def simulation_faults(robot: RobotDescription, arena: Arena) -> Iterator[tuple[str, str, str]]:
    """Table, key and a sentence of each."""
    base = robot.base
    if base is Base.ROV and arena.water is None:
        yield "[simulation]", "arena", NO_WATER
    for count, table in enumerate(robot.holds, start=1):
        if table.kind not in _HOLDS.get(base, ()):
            yield toml.repeated("hold", count), "kind", _NONE
    if robot.lights:
        yield toml.repeated("light", 1), "name", _NONE
    if len(robot.joints) > _JOINTS.get(base, 0):
        yield toml.repeated("joint", _JOINTS.get(base, 0) + 1), "name", _NONE
    if robot.arming is not Arming.NONE and base not in _HOLDS:
        yield "[body]", "arming", "a simulated body of this kind cannot be disarmed"
