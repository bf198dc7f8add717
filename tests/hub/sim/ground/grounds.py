"""Small grounds for tests, and bases that drive on them."""

from __future__ import annotations

import dataclasses
import math
import tomllib

from hub.sim.arena import Arena, arena_from_spec
from hub.sim.arena_file import check_arena
from hub.sim.ground.chassis import TRACKED, Chassis
from hub.sim.ground.height_field import HeightField
from hub.sim.rough_base import RoughBase

RAISED = (math.radians(35.0), 0.0)
"""Front flippers up, rear flippers level."""
GROUSERS = dataclasses.replace(TRACKED, grip=1.5)


def ground_arena(
    text: str, at: tuple[float, float] = (0.6, 1.5), heading_deg: float = 0.0
) -> Arena:
    """An arena of 3 m along y and as long as its text makes it; the start is on level floor."""
    head = f'name = "ground"\n[start]\nat = [{at[0]}, {at[1]}]\nheading_deg = {heading_deg}\n'
    spec, problems = check_arena(tomllib.loads(head + text))
    assert spec is not None, problems
    return arena_from_spec(spec)


def field_of(text: str) -> HeightField:
    ground = ground_arena(text).ground
    assert ground is not None
    return ground


def block(x: float, height: float, length: float = 3.0, y: float = 0.0, width: float = 3.0) -> str:
    """A raised floor with upright sides."""
    size = f"size = [{length}, {width}]"
    return f"[[ramp]]\nat = [{x}, {y}]\n{size}\nlow = {height}\nhigh = {height}\n"


def ramp(degrees: float) -> str:
    """A ramp of 2 m from x = 1.5 towards east, and a raised floor behind it."""
    top = 2.0 * math.tan(math.radians(degrees))
    return f"[[ramp]]\nat = [1.5, 0.0]\nsize = [2.0, 3.0]\nhigh = {top}\n" + block(3.5, top)


def stepfields(pattern: str, unit: float, seed: int) -> str:
    """Three fields side by side across the way, from x = 1.5 to 2.6."""
    return "".join(
        f'[[stepfield]]\nat = [1.5, {-0.15 + 1.1 * number}]\npattern = "{pattern}"\n'
        f"unit = {unit}\nseed = {seed * 3 + number}\n"
        for number in range(3)
    )


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """How a drive went.

    Attributes:
        base: The base at its end.
        roll_deg: Largest roll on the way.
        pitch_deg: Largest pitch on the way.
    """

    base: RoughBase
    roll_deg: float
    pitch_deg: float


def drive(base: RoughBase, until_x: float, seconds: float = 16.0, linear: float = 0.4) -> Drive:
    """Drive on until the base is somewhere, spins for a second, or tips."""
    roll = pitch = spins = 0.0
    base.command(linear, 0.0)
    for _ in range(round(seconds / 0.1)):
        base.advance(0.1)
        roll, pitch = max(roll, abs(base.pose.roll)), max(pitch, abs(base.pose.pitch))
        spins = spins + 0.1 if base.stuck else 0.0
        if base.tipped or spins > 1.0 or (base.pose.x > until_x):
            break
    return Drive(base=base, roll_deg=math.degrees(roll), pitch_deg=math.degrees(pitch))


def drive_over(text: str, chassis: Chassis, until_x: float, **more: float) -> Drive:
    """Drive east over a ground, with flippers as for climbing."""
    flippers = RAISED if chassis.flippers else None
    return drive(RoughBase(ground_arena(text), chassis, flippers=flippers), until_x, **more)
