"""The real range of an axis: measured with the operator, or learned in use; pure."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence

from hub.values import dataclass

TIME_TO_ACT_S = 60.0
"""How long a step of the guide waits for the operator [s]."""
_LEAST_RANGE = 0.25
"""Least distance between the ends of an axis, as a share of its nominal range."""
_LEAST_END = 0.6
"""Ends nearer than this share of the nominal range are not valid."""
_SAME_END = 0.016
"""Ends that differ by less are one, two steps of an axis with eight bits."""
_TIMES = 4
_BACK = 0.1
"""Largest share of the range at which an axis counts as at rest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """The range of raw numbers of an axis.

    Attributes:
        low: The least.
        high: The largest.
        centre: At rest, between them; None: the axis rests at one end.
    """

    low: int
    high: int
    centre: int | None = None

    @property
    def sound(self) -> bool:
        """Whether an axis can be like that."""
        return self.low < self.high if self.centre is None else self.low < self.centre < self.high


class Ends:
    """Learns the ends of an axis that never reaches its nominal range.

    Where it turns back at the same place several times in a row, it has its stop: no hand does
    that without one.
    """

    def __init__(self) -> None:
        self.negative = 1.0
        self.positive = 1.0
        self._far = 0.0
        self._turns: dict[bool, list[float]] = {False: [], True: []}

    def look(self, share: float) -> bool:
        """Take the position of the axis, as a share of its nominal range.

        Returns:
            Whether an end was found or moved; True only while the axis rests.
        """
        same_side = share * self._far > 0.0
        if abs(share) > _BACK and (same_side or not self._far):
            self._far = max(self._far, share, key=abs)
            return False
        turned, self._far = self._far, (share if abs(share) > _BACK else 0.0)
        return turned != 0.0 and self._turned(abs(turned), positive=turned > 0.0)

    def _turned(self, far: float, *, positive: bool) -> bool:
        turns = self._turns[positive]
        turns.append(far)
        del turns[:-_TIMES]
        before = self.positive if positive else self.negative
        stop = len(turns) == _TIMES and max(turns) - min(turns) <= _SAME_END
        end = min(turns) if stop and far >= _LEAST_END else before
        if far > end + _SAME_END:
            end = min(1.0, far)  # it goes beyond its known range
        if positive:
            self.positive = end
        else:
            self.negative = end
        return end != before


class CalibrationStep(enum.Enum):
    """The steps of the operator with an axis, in order."""

    MAXIMUM = "to its maximum (up, right, away from you)"
    MINIMUM = "to its minimum"
    REST = "nowhere: let go of it"


@dataclass(frozen=True, slots=True, kw_only=True)
class GuidedAxis:
    """An axis that the operator moves for its calibration.

    Attributes:
        control: Its name in the layout.
        usage: Its name on the device.
        lever: Whether it rests at one end, so that its rest is not measured.
        width: Its nominal range.
    """

    control: str
    usage: str
    lever: bool
    width: int


class Guide:
    """Asks for the ends of one axis after the other; the clock is passed in.

    Attributes:
        found: The results, by the axes' usages.
        ended: Whether nothing more is asked.
        given_up: Whether the operator did nothing for too long.
    """

    def __init__(self, axes: Sequence[GuidedAxis], now: float) -> None:
        """Begin.

        Args:
            axes: The axes to measure.
            now: The time now [s].
        """
        self.found: dict[str, Calibration] = {}
        self.given_up = False
        self._left = list(axes)
        self._step = CalibrationStep.MAXIMUM
        self._raws: dict[CalibrationStep, int] = {}
        self._problem = ""
        self._asked = now

    @property
    def ended(self) -> bool:
        """Whether nothing more is asked."""
        return not self._left or self.given_up

    @property
    def prompt(self) -> str:
        """The request to the operator; empty: it has ended."""
        if self.ended:
            return ""
        axis = self._left[0].control
        asked = (
            f"let go of {axis}"
            if self._step is CalibrationStep.REST
            else f"move {axis} {self._step.value}"
        )
        return f"{self._problem}Calibration: {asked}, then press a button of the device"

    def expire(self, now: float) -> None:
        """Apply the time limits."""
        if not self.ended and now - self._asked > TIME_TO_ACT_S:
            self.given_up = True

    def accept(self, raws: Mapping[str, int | None], now: float) -> None:
        """The operator pressed a button while the axes, by usage, gave these numbers."""
        if self.ended:
            return
        axis, self._asked = self._left[0], now
        raw = raws.get(axis.usage)
        if raw is None:
            self._problem = f"Nothing has come from {axis.control} yet. "
            return
        self._problem = ""
        self._raws[self._step] = raw
        steps = [
            step for step in CalibrationStep if step is not CalibrationStep.REST or not axis.lever
        ]
        if self._step is not steps[-1]:
            self._step = steps[steps.index(self._step) + 1]
            return
        self._conclude(axis)

    def _conclude(self, axis: GuidedAxis) -> None:
        low, high = sorted(
            (self._raws[CalibrationStep.MAXIMUM], self._raws[CalibrationStep.MINIMUM])
        )
        calibration = Calibration(low=low, high=high, centre=self._raws.get(CalibrationStep.REST))
        self._raws, self._step = {}, CalibrationStep.MAXIMUM
        if not calibration.sound or high - low < _LEAST_RANGE * axis.width:
            self._problem = f"That cannot be: {axis.control} gave {low} to {high}. "
            if calibration.centre is not None:
                self._problem = self._problem[:-2] + f" and {calibration.centre} at rest. "
            return
        self.found[axis.usage] = calibration
        del self._left[0]
