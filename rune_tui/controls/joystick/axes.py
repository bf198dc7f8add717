"""The axes of a joystick that a layout uses: raw numbers in, values out; pure."""

from __future__ import annotations

import dataclasses
from dataclasses import field

from hub.values import dataclass
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.joystick.calibration import Calibration, Ends
from rune_tui.controls.joystick.shaping import (
    CALIBRATED_DEAD_ZONE,
    DEAD_ZONE,
    LEVER_DEAD_ZONE,
    STICK_EXPO,
    AxisRange,
    Shape,
)
from rune_tui.layout.names import ONE_SIDED
from rune_tui.layout.spec import ControlSpec

_LEVERS = frozenset({"slider", "throttle", "accelerator", "brake", "clutch"})
"""Usages that rest at one end."""
_AT_REST_S = 0.5
"""An axis that stays in the middle for this time rests there [s]."""


@dataclass(slots=True, kw_only=True)
class Axis:
    """An axis in use.

    Attributes:
        name: Its name in the layout.
        physical: Its axis on the device.
        shape: The shaping of its value.
        lever: Whether it rests at one end.
        range: The raw numbers of its ends and its rest.
        raw: The newest raw number; None: no report yet.
    """

    name: str
    physical: PhysicalControl
    shape: Shape
    lever: bool
    range: AxisRange
    nominal: AxisRange
    calibrated: bool
    raw: int | None = None
    since: float = 0.0
    ends: Ends = field(default_factory=Ends)

    @classmethod
    def of(
        cls, spec: ControlSpec, physical: PhysicalControl, known: Calibration | None = None
    ) -> Axis:
        """The axis of a layout, on a device with this calibration."""
        low = physical.minimum if spec.minimum is None else spec.minimum
        high = physical.maximum if spec.maximum is None else spec.maximum
        inverted = spec.invert != physical.flipped
        usage = physical.usage.partition("#")[0]
        lever = usage in _LEVERS or bool({physical.role, spec.role} & ONE_SIDED)
        calibrated = known is not None and spec.minimum is None and spec.maximum is None
        if known is not None and calibrated:
            low, high = known.low, known.high
        if lever:
            wide = AxisRange.lever(low, high, down=inverted)
        elif known is not None and calibrated and known.centre is not None:
            wide = AxisRange(low=low, rest_low=known.centre, rest_high=known.centre, high=high)
        else:
            wide = AxisRange.centred(low, high)
        dead_zone = CALIBRATED_DEAD_ZONE if calibrated else DEAD_ZONE
        dead_zone = LEVER_DEAD_ZONE if lever else dead_zone
        shape = Shape(
            inverted=inverted,
            dead_zone=dead_zone if spec.deadzone is None else spec.deadzone,
            expo=(0.0 if lever else STICK_EXPO) if spec.expo is None else spec.expo,
        )
        return cls(
            name=spec.name,
            physical=physical,
            shape=shape,
            lever=lever,
            range=wide,
            nominal=wide,
            calibrated=calibrated,
        )

    def take(self, raw: int, now: float) -> None:
        """Take a raw number of the device.

        The first number is the rest, if it is near the middle. A hand may have held the axis
        then, so a later pause in the middle corrects the rest.
        """
        if self.raw is None and not (self.lever or self.calibrated):
            self.range = self.nominal.resting_at(raw)
        elif self.raw is not None and now - self.since > _AT_REST_S and self._in_middle(self.raw):
            self.range = dataclasses.replace(
                self.range, rest_low=self.nominal.rest_low, rest_high=self.nominal.rest_high
            )
        if raw != self.raw:
            self.raw, self.since = raw, now
            self._learn()

    def _learn(self) -> None:
        """Follow the ends that have become clear."""
        nominal = self.nominal
        if self.raw is None or self.lever or not self.ends.look(nominal.share(self.raw)):
            return
        middle = nominal.rest_low
        self.range = AxisRange(
            low=middle - self.ends.negative * (middle - nominal.low),
            rest_low=self.range.rest_low,
            rest_high=self.range.rest_high,
            high=middle + self.ends.positive * (nominal.high - middle),
        )

    @property
    def share(self) -> float:
        """Its shaped value with the layout's sign; 0: no report yet."""
        return 0.0 if self.raw is None else self.shape.turned(self.range.share(self.raw))

    def _in_middle(self, raw: int) -> bool:
        return abs(self.nominal.share(raw)) <= self.shape.dead_zone
