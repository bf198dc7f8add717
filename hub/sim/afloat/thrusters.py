"""Thrusters: the propellers of the blimp, and eight T200 of the underwater robot.

The T200's curve is the polynomial of von Benzon et al. 2022 (An Open-Source Benchmark Simulator:
Control of a BlueROV2 Underwater Robot, J. Mar. Sci. Eng. 10(12), 1898). The places and directions
of the eight are those of the BlueROV2 Heavy there.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.afloat.floating_body import Six

Floats = npt.NDArray[np.float64]

PROPELLER_LAG = 0.15
"""Time constant of the blimp's propellers [s]; our assumption."""
THRUSTER_LAG = 0.1
"""Time constant of a T200's speed [s]; our assumption."""
FRONT = (0.040, 0.045)
"""Most thrust of the front propeller [N], ahead and back; blimp2b.c of Webots."""
TAIL = (0.025, 0.030)
"""Most thrust of the tail propeller [N], for a turn to the left and to the right; blimp2b.c."""
LIFT = (0.045, 0.025)
"""Most thrust of the lift propeller [N], up and down; blimp2b.c."""
FRONT_BELOW = 0.144
"""Front propeller below the centre of buoyancy [m]; blimp2b.c."""
TAIL_BELOW = 0.073
TAIL_BEHIND = 0.484
LIFT_AHEAD = 0.045

_DIAGONAL = math.sqrt(0.5)
_CORNERS = tuple((ahead, left) for ahead in (1, -1) for left in (1, -1))
_PLACES = np.array(
    [(0.156 * ahead, 0.111 * left, -0.085) for ahead, left in _CORNERS]
    + [(0.120 * ahead, 0.218 * left, 0.0) for ahead, left in _CORNERS]
)
_DIRECTIONS = np.array(
    [(_DIAGONAL, -ahead * left * _DIAGONAL, 0.0) for ahead, left in _CORNERS]
    + [(0.0, 0.0, 1.0)] * 4
)
_MOMENTS = np.cross(_PLACES, _DIRECTIONS).astype(np.float64)
MIX: Floats = np.concatenate((_DIRECTIONS, _MOMENTS), axis=1).T
"""Forces and moments of unit thrusts, shape (6, 8)."""
_SHARES = np.linalg.pinv(MIX).astype(np.float64)
_LEVEL_FOUR = slice(0, 4)
_UPRIGHT_FOUR = slice(4, 8)


def t200_thrust(throttle: Floats) -> Floats:
    """Thrust [N] at a share of full throttle, -1 to 1; it falls a little beyond 0.972."""
    v = throttle
    return np.asarray(-140.3 * v**9 + 389.9 * v**7 - 404.1 * v**5 + 176.0 * v**3 + 8.9 * v)


def _rising_curve() -> tuple[Floats, Floats]:
    """Throttles and thrusts between the two peaks, where the curve only rises."""
    throttles = np.linspace(-1.0, 1.0, 2049)
    thrusts = t200_thrust(throttles)
    low, high = int(thrusts.argmin()), int(thrusts.argmax())
    return throttles[low : high + 1], thrusts[low : high + 1]


_THROTTLES, _THRUSTS = _rising_curve()
MOST_THRUST = float(_THRUSTS[-1])
"""Of one T200 [N]."""


def t200_throttle(thrust: Floats) -> Floats:
    """The throttle for a thrust [N]; the peak's for more than the most."""
    return np.interp(thrust, _THRUSTS, _THROTTLES)


class EightThrusters:
    """Eight T200: their throttles follow what is wanted with a lag.

    Attributes:
        wrench: Forces and moments that they make now in water [N, N m].
        power: Electric power that they take [W].
    """

    POWER_PER_THRUST = 1.0
    """Power per thrust to 3/2 [W/N^1.5], of the data sheet: 36 N take 204 W at 12 V."""

    def __init__(self) -> None:
        self._throttles = np.zeros(8)
        self.wrench: Six = (0.0,) * 6
        self.power = 0.0

    def advance(self, wanted: Six, seconds: float) -> None:
        """Follow the wanted forces and moments [N, N m] for some time [s]."""
        goal = t200_throttle(allocated(wanted))
        self._throttles += (1.0 - math.exp(-seconds / THRUSTER_LAG)) * (goal - self._throttles)
        thrusts = np.interp(self._throttles, _THROTTLES, _THRUSTS)
        x, y, z, roll, pitch, yaw = (MIX @ thrusts).tolist()
        self.wrench = (x, y, z, roll, pitch, yaw)
        sizes = np.abs(thrusts)
        self.power = self.POWER_PER_THRUST * float(sizes @ np.sqrt(sizes))


def allocated(wanted: Six) -> Floats:
    """Thrusts [N] for forces and moments [N, N m], shape (8,).

    Where they do not suffice, surge, sway and yaw shrink together, and heave shrinks before roll
    and pitch: the robot stays upright.
    """
    wrench = np.array(wanted)
    thrusts: Floats = _SHARES @ wrench
    sizes = np.abs(thrusts)
    if sizes.max() <= MOST_THRUST:
        return thrusts
    most = float(sizes[_LEVEL_FOUR].max())
    if most > MOST_THRUST:
        wrench[[0, 1, 5]] *= MOST_THRUST / most
        thrusts = _SHARES @ wrench
    upright = thrusts[_UPRIGHT_FOUR]
    if float(np.abs(upright).max()) > MOST_THRUST:
        heave = float(upright.mean())
        tilting = upright - heave
        low, high = -MOST_THRUST - float(tilting.min()), MOST_THRUST - float(tilting.max())
        thrusts[_UPRIGHT_FOUR] = tilting + max(low, min(high, heave))
    return np.clip(thrusts, -MOST_THRUST, MOST_THRUST)


class Propellers:
    """The blimp's three propellers: front, tail and lift.

    Attributes:
        ahead: Thrust of the front propeller [N].
        left: Thrust of the tail propeller for a turn to the left [N].
        up: Thrust of the lift propeller [N].
        power: Electric power that they take [W].
    """

    POWER_PER_THRUST = 180.0
    """Power per thrust to 3/2 [W/N^1.5]; our assumption for propellers of some centimetres."""

    def __init__(self) -> None:
        self.ahead = 0.0
        self.left = 0.0
        self.up = 0.0
        self.power = 0.0

    def advance(self, ahead: float, left: float, up: float, seconds: float) -> None:
        """Follow the wanted thrusts [N] for some time [s]."""
        share = 1.0 - math.exp(-seconds / PROPELLER_LAG)
        self.ahead += share * (_within(ahead, FRONT) - self.ahead)
        self.left += share * (_within(left, TAIL) - self.left)
        self.up += share * (_within(up, LIFT) - self.up)
        strength = abs(self.ahead) ** 1.5 + abs(self.left) ** 1.5 + abs(self.up) ** 1.5
        self.power = self.POWER_PER_THRUST * strength

    @property
    def wrench(self) -> Six:
        """Forces and moments that they make now [N, N m]; each sits off the axes."""
        ahead, left, up = self.ahead, self.left, self.up
        return (
            ahead,
            -left,
            up,
            -TAIL_BELOW * left,
            -FRONT_BELOW * ahead - LIFT_AHEAD * up,
            TAIL_BEHIND * left,
        )


def _within(thrust: float, most: tuple[float, float]) -> float:
    return max(-most[1], min(most[0], thrust))
