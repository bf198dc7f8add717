"""The buttons of a Sub's joystick, as its parameters BTNn_FUNCTION say; pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from hub.robots.simulated_autopilot.condition import INFO, VehicleCondition

_BUTTONS: Final = 16
_ARM, _DISARM = 3, 4
_MODES: Final = {5: 19, 6: 2, 7: 0, 8: 2, 9: 3, 10: 4, 11: 7, 12: 1, 13: 16, 15: 9}
_TILT_STEP: Final = math.radians(1.0)
_TILT_MOST: Final = math.radians(45.0)


def _brighten(vehicle: VehicleCondition, sign: float, number: int = 0) -> None:
    step = sign / max(1.0, vehicle.parameters["JS_LIGHTS_STEPS"])
    vehicle.lights[number] = max(0.0, min(1.0, vehicle.lights[number] + step))


def _brighten_second(vehicle: VehicleCondition, sign: float) -> None:
    _brighten(vehicle, sign, 1)


def _gain(vehicle: VehicleCondition, sign: float) -> None:
    least, most = (
        max(0.0, min(1.0, vehicle.parameters[f"JS_GAIN_{end}"])) for end in ("MIN", "MAX")
    )
    step = (most - least) / max(1.0, vehicle.parameters["JS_GAIN_STEPS"] - 1.0)
    vehicle.gain = max(least, min(most, vehicle.gain + sign * step))
    vehicle.say(INFO, f"#Gain is {vehicle.gain * 100.0:2.0f}%")


def _center(vehicle: VehicleCondition, _sign: float) -> None:
    vehicle.tilt = 0.0


_ONCE: Final[Mapping[int, tuple[Callable[[VehicleCondition, float], None], float]]] = {
    21: (_center, 0.0),
    32: (_brighten, 1.0),
    33: (_brighten, -1.0),
    35: (_brighten_second, 1.0),
    36: (_brighten_second, -1.0),
    42: (_gain, 1.0),
    43: (_gain, -1.0),
}
_HELD: Final = {22: 1.0, 23: -1.0}
"""Functions that tilt the camera while the button is pressed."""


class JoystickButtons:
    """Does what buttons say: most once for each press."""

    def __init__(self, vehicle: VehicleCondition) -> None:
        self._vehicle = vehicle
        self._pressed = 0

    def take(self, buttons: int) -> None:
        """Take the buttons of a MANUAL_CONTROL, a bit each."""
        vehicle = self._vehicle
        for number in range(_BUTTONS):
            bit = 1 << number
            function = int(vehicle.parameters[f"BTN{number}_FUNCTION"])
            if not buttons & bit:
                continue
            if function in _HELD:
                tilt = vehicle.tilt + _HELD[function] * _TILT_STEP
                vehicle.tilt = max(-_TILT_MOST, min(_TILT_MOST, tilt))
            elif not self._pressed & bit:
                self._press(function)
        self._pressed = buttons

    def _press(self, function: int) -> None:
        vehicle = self._vehicle
        if function == _ARM:
            vehicle.ask_arm(force=False)
        elif function == _DISARM:
            vehicle.disarm()
        elif function in _MODES:
            vehicle.ask_mode(_MODES[function])
        elif function in _ONCE:
            act, sign = _ONCE[function]
            act(vehicle, sign)
