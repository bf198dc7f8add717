"""The orders that change a vehicle's mode or arm it, and whose mode it is in; pure.

| event | the operator's order to drive | whose mode |
| --- | --- | --- |
| a driving mode or arming is asked for | valid | the hub's, for 3 s |
| another mode is asked for | ends | the hub's, as above |
| the vehicle refuses | ends | another's |
| the vehicle is seen in the mode that was asked for | stays | the hub's |
| the vehicle is seen in another mode | ends | another's |
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.robots.mavlink.vehicle.requests import ACCEPTED, RESULTS, RequestQueue, VehicleRequest
from hub.robots.mavlink.vehicle.texts import VehicleTexts

CHANGING_S: Final = 3.0
"""Longest time of a change of mode [s]."""
_REASON_BEFORE_S: Final = 1.5
_REASON_AFTER_S: Final = 0.5
"""Texts so short before and after a refusal give its reason [s]."""
_MODE: Final = 176
"""MAV_CMD_DO_SET_MODE."""
_ARM: Final = 400
"""MAV_CMD_COMPONENT_ARM_DISARM."""
_CUSTOM: Final = 1.0
_NONE: Final = -1


class ModeOrders:
    """The orders to one vehicle; times are monotonic [s].

    Attributes:
        follows: Whether the operator's order to drive is valid.
        number: The mode that was asked for; -1: none, or another has changed it.
    """

    def __init__(self, requests: RequestQueue, texts: VehicleTexts) -> None:
        self._requests, self._texts = requests, texts
        self.follows = False
        self.number = _NONE
        self._until = -math.inf
        self._refusal = ""
        self._result = ""
        self._refused_at = -math.inf

    def changing(self, now: float) -> bool:
        """Whether a mode was asked for a short while ago, and has not been seen yet."""
        return now < self._until

    def chosen_here(self, mode: int, now: float) -> bool:
        """Whether a mode of the vehicle was asked for here, or another is about to be."""
        return self.changing(now) or mode == self.number

    def refusal(self) -> str:
        """The last refusal with the vehicle's own reason; empty: none since the last order."""
        if not self._refusal:
            return ""
        since, until = self._refused_at - _REASON_BEFORE_S, self._refused_at + _REASON_AFTER_S
        texts = [each.text for each in self._texts.since(since) if each.time <= until]
        return f"{self._refusal} was refused: {'; '.join(dict.fromkeys(texts)) or self._result}"

    def change(
        self,
        profile: VehicleProfile,
        numbers: Sequence[int],
        now: float,
        *,
        drives: bool,
        after: float = 0.0,
        arm: Callable[[], None] | None = None,
    ) -> None:
        """Ask for the first of these modes, and for the next one where it is refused.

        Args:
            profile: The vehicle's kind.
            numbers: The modes, the best first.
            now: The time.
            drives: Whether the operator asks to drive.
            after: Time until the first request [s].
            arm: Called when a mode is accepted, to arm the vehicle; None: it stays as it is.
        """
        number, *others = numbers
        self.follows, self.number = drives, number
        self._until = now + after + CHANGING_S
        self._refusal = ""
        self._requests.drop((_MODE, _ARM))

        def answered(result: int, at: float) -> None:
            if result == ACCEPTED:
                if arm is not None:
                    arm()
            elif others:
                self.change(profile, others, at, drives=drives, arm=arm)
            else:
                self.refused(f"the mode {profile.mode_name(number)}", result, at)

        self._requests.add(
            VehicleRequest(
                command=_MODE,
                parameters=(_CUSTOM, float(number)),
                answered=answered,
                due=now + after,
            )
        )

    def arm(self, refused: Callable[[], None]) -> None:
        """Ask the vehicle to arm, once.

        Args:
            refused: Called when it refuses.
        """

        def answered(result: int, at: float) -> None:
            if result != ACCEPTED:
                self.refused("to arm", result, at)
                refused()

        self._requests.add(
            VehicleRequest(command=_ARM, parameters=(1.0,), answered=answered, tries=1)
        )

    def disarm(self) -> None:
        """Ask the vehicle to disarm, before all other requests."""

        def answered(result: int, at: float) -> None:
            if result != ACCEPTED:
                self.refused("to disarm", result, at)

        self.end()
        self._requests.drop((_MODE, _ARM))
        request = VehicleRequest(command=_ARM, parameters=(0.0,), answered=answered)
        self._requests.add(request, first=True)

    def seen(self, mode: int, now: float, *, drives: bool) -> None:
        """Take the mode of an armed vehicle.

        Args:
            mode: Its number.
            now: The time.
            drives: Whether it follows velocities in it.
        """
        if mode == self.number:
            self._until = min(self._until, now)
            self.follows = self.follows and drives
        elif not self.changing(now):
            self.end()

    def refused(self, what: str, result: int, now: float) -> None:
        """Keep a refusal; the order to drive ends."""
        self._refusal, self._refused_at = what, now
        self._result = RESULTS.get(result, f"result {result}")
        self.end()

    def end(self) -> None:
        """The operator's order to drive ends, and the mode is another's."""
        self.follows = False
        self.number, self._until = _NONE, -math.inf

    def forget(self) -> None:
        """As `end`; a refusal is no longer of interest either."""
        self.end()
        self._refusal = ""
