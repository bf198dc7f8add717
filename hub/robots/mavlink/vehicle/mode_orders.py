"""The orders that change a vehicle's mode or arm it, and whose mode it is in; pure.

| event | the operator's order to drive | whose mode |
| --- | --- | --- |
| a driving mode or arming is asked for | valid | the hub's, for 3 s |
| another mode is asked for | ends | the hub's, as above |
| the vehicle refuses, and no other mode will do | ends | as before the order |
| the vehicle is seen in the mode that was asked for | stays | the hub's |
| the vehicle is seen in another mode | ends | another's |
| the vehicle is gone | ends, if its mode was not seen yet | as before the order |

Only a heartbeat shows what was done. A vehicle that starts accepts a mode and forgets it: it is
asked again. It is asked to arm once, in the mode that a heartbeat shows.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from hub.gcm.diagnostics import Severity
from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.robots.mavlink.vehicle.requests import (
    ACCEPTED,
    NO_ANSWER,
    RESULTS,
    RequestKind,
    RequestQueue,
    VehicleRequest,
)
from hub.robots.mavlink.vehicle.texts import VehicleTexts
from hub.values import dataclass

CHANGING_S: Final = 3.0
"""Longest time of a change of mode [s]."""
ARMING_S: Final = 5.0
"""Longest time of arming [s]."""
_SHOWN_S: Final = 1.2
"""Longest time from an accepted order to the heartbeat that shows it [s]."""
_REASON_BEFORE_S: Final = 1.5
_REASON_AFTER_S: Final = 0.5
"""Texts so short before and after a refusal give its reason [s]."""
_MODE: Final = 176
"""MAV_CMD_DO_SET_MODE."""
_ARM: Final = 400
"""MAV_CMD_COMPONENT_ARM_DISARM."""
_DISARM_TRIES: Final = 10
_DISARMING_S: Final = 8.0
"""Longest time of disarming [s]."""
_NONE: Final = -1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModeOrder:
    """An order to change the mode.

    Attributes:
        profile: The vehicle's kind.
        numbers: The modes, the best first.
        drives: Whether the operator asks to drive.
        arms: Whether the vehicle is armed in the mode.
        named: Whether the operator named the mode.
    """

    profile: VehicleProfile
    numbers: Sequence[int]
    drives: bool = False
    arms: bool = False
    named: bool = False

    @staticmethod
    def to(profile: VehicleProfile, number: int, *, drives: bool) -> ModeOrder:
        """The order for one mode; `drives`: to drive in it, if it follows velocities."""
        drives = drives and number in profile.drives
        return ModeOrder(profile=profile, numbers=(number,), drives=drives, named=True)

    @staticmethod
    def driving(profile: VehicleProfile, *, place: bool, arms: bool = False) -> ModeOrder:
        """The order to drive; `place`: it knows its place."""
        numbers = profile.drives_with(place=place)
        return ModeOrder(profile=profile, numbers=numbers, drives=True, arms=arms)

    @property
    def needs_place(self) -> bool:
        """Whether its first mode begins only where the vehicle knows its place."""
        return self.numbers[0] in self.profile.need_place


class ModeOrders:
    """The orders to one vehicle; times are monotonic [s].

    Attributes:
        follows: Whether the operator's order to drive is valid.
        number: The mode that is asked for; -1: none.
        named: Whether the operator named the mode of the last order.
    """

    def __init__(self, requests: RequestQueue, texts: VehicleTexts) -> None:
        self._requests, self._texts = requests, texts
        self.follows = self.named = False
        self.number = _NONE
        self._own = _NONE
        self._order: ModeOrder | None = None
        self._again_at = self._disarmed_at = math.inf
        self._until = self._arming_until = self._disarming_until = -math.inf
        self._refusal = self._result = ""
        self._refused_at = -math.inf

    def changing(self, now: float) -> bool:
        """Whether a mode was asked for a short while ago, and has not been seen yet."""
        return now < self._until

    def arming(self, now: float) -> bool:
        """Whether the vehicle was asked to arm, and may still do so."""
        return now < self._arming_until

    def disarming(self, now: float) -> bool:
        """Whether the vehicle was asked to disarm, and may still do so."""
        return now < self._disarming_until

    def chosen_here(self, mode: int, now: float) -> bool:
        """Whether a mode of the vehicle was asked for here, or another is about to be."""
        return self.changing(now) or mode == self._own

    def refusal(self) -> str:
        """The last refusal with the vehicle's own reason; empty: none since the last order."""
        if not self._refusal:
            return ""
        since, until = self._refused_at - _REASON_BEFORE_S, self._refused_at + _REASON_AFTER_S
        texts = [
            each.text
            for each in self._texts.since(since)
            if each.time <= until and each.level is not Severity.OK
        ]
        return f"{self._refusal} was refused: {'; '.join(dict.fromkeys(texts)) or self._result}"

    def change(self, order: ModeOrder, now: float, after: float = 0.0) -> None:
        """Ask for the first mode of an order, and for the next one where it is refused.

        Args:
            order: What is asked for.
            now: The time.
            after: Time until the first request [s].
        """
        self._requests.drop(RequestKind.ORDER)
        self.follows, self.named = order.drives, order.named
        self.number = order.numbers[0]
        self._order, self._again_at = order, math.inf
        self._until = now + after + CHANGING_S
        self._refusal = ""
        if order.arms:
            self._requests.drop(RequestKind.DISARM)
            self._disarming_until = -math.inf
            self._arming_until = now + ARMING_S
        self._ask_mode(order, now + after)

    def refuse_without_place(self, order: ModeOrder, now: float) -> None:
        """Ask for nothing, and say why.

        Some modes that begin without a place leave a vehicle unable to arm until it is booted.
        """
        name = order.profile.mode_name(order.numbers[0])
        self._refusal, self._refused_at = f"the mode {name}", now
        self._result = "it does not know its place yet"

    def disarm(self, now: float) -> None:
        """Ask the vehicle to disarm, before all other requests."""
        self.end()
        self._disarming_until = now + _DISARMING_S
        self._ask_disarm()

    def step(self, mode: int, now: float, *, armed: bool) -> None:
        """Go on with the orders.

        Args:
            mode: The present mode of the vehicle, by its heartbeat.
            now: The time.
            armed: Whether it is armed, by its heartbeat.
        """
        if not armed:
            self._disarmed_at = math.inf
        elif now >= self._disarmed_at and now < self._disarming_until:
            self._ask_disarm()
        order = self._order
        if order is None or self._again_at == math.inf:
            return
        if mode == self.number:
            self._order = None
            if order.arms:
                self._ask_arm(order)
        elif now >= self._again_at and self.changing(now):
            self._again_at = math.inf
            self._ask_mode(order, now)

    def seen(self, mode: int, now: float, *, drives: bool) -> None:
        """Take the mode of an armed vehicle.

        Args:
            mode: Its number.
            now: The time.
            drives: Whether it follows velocities in it.
        """
        if mode == self.number:
            self._own = mode
            self._until = min(self._until, now)
            self.follows = self.follows and drives
        elif not self.changing(now):
            self.end()
            if mode != self._own:
                self._own = _NONE

    def gone(self) -> None:
        """The vehicle is gone: what it was asked for and has not done yet ends."""
        self._requests.drop(RequestKind.ORDER)
        if self.number != self._own:
            self.end()

    def end(self) -> None:
        """The operator's order to drive ends; nothing of it is sent later."""
        self._requests.drop(RequestKind.ORDER)
        self.follows = False
        self.number, self._order = _NONE, None
        self._until = self._arming_until = -math.inf

    def release(self) -> None:
        """As `end`; the mode is another's."""
        self.end()
        self._own = _NONE

    def forget(self) -> None:
        """As `release`; a refusal is no longer of interest either."""
        self.release()
        self._refusal = ""

    # Inside.

    def _ask_disarm(self) -> None:
        self._disarmed_at = math.inf
        self._requests.drop(RequestKind.DISARM)
        self._requests.add(
            VehicleRequest(
                kind=RequestKind.DISARM,
                command=_ARM,
                parameters=(0.0,),
                answered=self._disarm_answered,
                tries=_DISARM_TRIES,
            )
        )

    def _ask_mode(self, order: ModeOrder, due: float) -> None:
        self._requests.add(
            VehicleRequest(
                kind=RequestKind.ORDER,
                command=_MODE,
                parameters=order.profile.mode_parameters(order.numbers[0]),
                answered=functools.partial(self._mode_answered, order),
                due=due,
            )
        )

    def _ask_arm(self, order: ModeOrder) -> None:
        self._requests.add(
            VehicleRequest(
                kind=RequestKind.ORDER,
                command=_ARM,
                parameters=(1.0,),
                answered=functools.partial(self._arm_answered, order),
                tries=1,
            )
        )

    def _mode_answered(self, order: ModeOrder, result: int, now: float) -> None:
        if result == ACCEPTED:
            self._again_at = now + _SHOWN_S
        else:
            name = order.profile.mode_name(order.numbers[0])
            self._refused(order, f"the mode {name}", result, now)

    def _arm_answered(self, order: ModeOrder, result: int, now: float) -> None:
        if result != ACCEPTED:
            self._refused(order, "to arm", result, now)

    def _disarm_answered(self, result: int, now: float) -> None:
        if result == ACCEPTED:
            self._disarmed_at = now + _SHOWN_S
        else:
            self._keep_refusal("to disarm", result, now)

    def _refused(self, order: ModeOrder, what: str, result: int, now: float) -> None:
        """Ask for the next mode of an order; without one, the order ends."""
        others = order.numbers[1:]
        if others and result != NO_ANSWER:
            self.change(replace(order, numbers=others), now)
            return
        self._keep_refusal(what, result, now)
        self.end()

    def _keep_refusal(self, what: str, result: int, now: float) -> None:
        self._refusal, self._refused_at = what, now
        self._result = RESULTS.get(result, f"result {result}")
