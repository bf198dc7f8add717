"""Bumps into obstacles, by the side of the robot."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.statistics.arrays import Floats, floats

REARM_S = 1.0
"""Contacts that begin sooner after a bump belong to it [s]."""
GRACE_S = 0.1
"""A bumper may be pressed this much before the contact is counted [s]."""
FRONT = math.radians(67.5)
REAR = math.radians(112.5)
"""A bump is in front up to the first angle from straight ahead, at the rear from the second on."""
SIXTEEN = tuple(np.deg2rad(22.5 * np.arange(16)).tolist())
"""Directions of 16 bumpers around a robot, counter-clockwise from straight ahead [rad]."""

_EQUAL = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Bumps:
    """How often a robot bumped into something.

    Attributes:
        front: Ahead.
        rear: Behind.
        side: At its sides.
    """

    front: int
    rear: int
    side: int

    @property
    def total(self) -> int:
        """All of them."""
        return self.front + self.rear + self.side


def bumps(
    times: npt.ArrayLike,
    contacts: npt.ArrayLike,
    bumpers: npt.ArrayLike,
    linear: npt.ArrayLike,
    *,
    directions: tuple[float, ...] = SIXTEEN,
    rearm: float = REARM_S,
) -> Bumps:
    """Count bumps: a contact counter that rises, unless the last bump is too recent.

    The side is that of the mean direction of the bumpers that are pressed then, or at most GRACE_S
    before. If none is, or their directions cancel out, it is where the robot drives to.

    Args:
        times: Ascending [s], shape (n,).
        contacts: Contacts so far, shape (n,); those of the first time are no bump.
        bumpers: Bit i is set while bumper i is pressed, shape (n,).
        linear: Forward speed [m/s], shape (n,).
        directions: Of each bumper, counter-clockwise from straight ahead [rad].
        rearm: Shortest time between two bumps [s].

    Raises:
        DataError: Lengths differ, times are not finite and ascending, counts are not finite, or
            bumpers are no whole numbers from 0 on.
    """
    at, count, speed = (
        floats(times, "times"),
        floats(contacts, "contacts"),
        floats(linear, "linear"),
    )
    try:
        bits = np.asarray(bumpers, np.uint64) if len(at) else np.empty(0, np.uint64)
    except (TypeError, ValueError, OverflowError):
        text = "bumpers: these are not all whole numbers from 0 on, whose bits are bumpers"
        raise DataError(text) from None
    if not len(at) == len(count) == len(speed) == len(bits):
        text = "contacts, bumpers and speeds need one value for each time"
        raise DataError(text)
    if not (np.isfinite(at).all() and np.isfinite(count).all()) or (np.diff(at) < 0.0).any():
        text = "contacts need finite, ascending times and finite counts"
        raise DataError(text)
    sides = {"front": 0, "rear": 0, "side": 0}
    for place in bump_moments(at, count, rearm=rearm):
        first = int(np.searchsorted(at, at[place] - GRACE_S - _EQUAL))
        pressed = next((int(each) for each in bits[first : place + 1][::-1] if each), 0)
        sides[_side(pressed, np.array(directions), float(speed[place]))] += 1
    return Bumps(**sides)


def bump_moments(times: Floats, contacts: Floats, *, rearm: float = REARM_S) -> list[int]:
    """Which of some moments are the begin of a bump, as `bumps` counts them.

    Args:
        times: Ascending [s], shape (n,).
        contacts: Contacts so far, shape (n,).
        rearm: Shortest time between two bumps [s].

    Returns:
        Indices of `times`.
    """
    found: list[int] = []
    last = -math.inf
    for place in (np.flatnonzero(np.diff(contacts) > 0.0) + 1).tolist():
        if times[place] - last >= rearm - _EQUAL:
            last = float(times[place])
            found.append(place)
    return found


def _side(pressed: int, directions: Floats, speed: float) -> str:
    chosen = [angle for bit, angle in enumerate(directions.tolist()) if pressed >> bit & 1]
    east, north = sum(map(math.cos, chosen)), sum(map(math.sin, chosen))
    if math.hypot(east, north) < 1e-6:
        return "rear" if speed < 0.0 else "front"
    away = abs(math.atan2(north, east))
    if away <= FRONT + _EQUAL:
        return "front"
    return "rear" if away >= REAR - _EQUAL else "side"
