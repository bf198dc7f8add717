"""Sets a light of a Sub by the buttons of a joystick, as nothing else does; pure.

| state | event | next state |
| --- | --- | --- |
| IDLE | a brightness is wanted, the present one and a button are known | PRESSED |
| PRESSED | the next frame | RELEASED |
| RELEASED | the next frame, presses are left | PRESSED |
| RELEASED | no press is left | LOOKING, 1.5 s |
| LOOKING | the wanted brightness is reported, or this was the third time | IDLE |
| LOOKING | another one is reported | PRESSED |
| any | 10 s since the order | IDLE |

A press is a step of JS_LIGHTS_STEPS. No button of another function is ever pressed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from hub.robots.mavlink.profiles.ardusub import BUTTON_FUNCTIONS, LIGHT_STEPS
from hub.robots.mavlink.profiles.profile import Parameters

_BRIGHTER: Final = (32.0, 35.0)
"""Functions of buttons that make both lights brighter; to each, the next function is dimmer."""
_STEPS: Final = 8.0
"""Steps from dark to bright where the vehicle does not say."""
_LOOKING_S: Final = 1.5
_LONGEST_S: Final = 10.0
_ROUNDS: Final = 3


class ButtonLight:
    """One light of a Sub; times are monotonic [s]."""

    def __init__(self, brighter: float) -> None:
        """Take the function of the button that makes it brighter."""
        self._brighter = brighter
        self._wanted = math.nan
        self._until = self._look_at = -math.inf
        self._presses = self._rounds = 0
        self._pressed = False

    def set(self, brightness: float, now: float) -> None:
        """Ask for a brightness, 0 to 1."""
        self._wanted = brightness
        self._until, self._look_at = now + _LONGEST_S, now
        self._presses, self._rounds = 0, _ROUNDS

    def buttons(self, parameters: Parameters, present: float, now: float) -> int:
        """The buttons of the frame that is sent now, a bit each.

        Args:
            parameters: The vehicle's parameters.
            present: The present brightness; NaN: not known.
            now: The time.
        """
        if self._pressed or now >= self._until:
            self._pressed = False
            return 0
        if not self._presses and now >= self._look_at and self._rounds and not math.isnan(present):
            steps = max(1.0, parameters.get(LIGHT_STEPS, _STEPS))
            self._presses = round((self._wanted - present) * min(steps, 100.0))
            self._rounds -= 1
        button = _button(parameters, self._brighter + (self._presses < 0))
        if not self._presses or not button:
            return 0
        self._presses -= 1 if self._presses > 0 else -1
        self._look_at = now + _LOOKING_S
        self._pressed = True
        return button


class ButtonLights:
    """Both lights of one Sub."""

    def __init__(self) -> None:
        self._lights = [ButtonLight(function) for function in _BRIGHTER]

    def set(self, number: int, brightness: float, now: float) -> None:
        """Ask light 1 or 2 for a brightness, 0 to 1; monotonic time [s]."""
        self._lights[number - 1].set(brightness, now)

    def buttons(self, parameters: Parameters, present: Callable[[int], float], now: float) -> int:
        """The buttons of the frame that is sent now, a bit each.

        Args:
            parameters: The vehicle's parameters.
            present: The present brightness of light 1 or 2; NaN: not known.
            now: Monotonic time [s].
        """
        pressed = 0
        for number, light in enumerate(self._lights, 1):
            pressed |= light.buttons(parameters, present(number), now)
        return pressed


def _button(parameters: Parameters, function: float) -> int:
    """The bit of the button with a function; 0: there is none."""
    numbers = (
        number for number, name in enumerate(BUTTON_FUNCTIONS) if parameters.get(name) == function
    )
    return next((1 << number for number in numbers), 0)
