"""The time of a trial: what is due when; pauses do not count. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

from hub.values import dataclass
from rune_study.plan.steps import Step

FREEZE, WITHHOLD, QUESTION = "freeze", "withhold", "question"


@dataclass(frozen=True, slots=True, kw_only=True)
class Due:
    """Something that begins at a moment of a trial.

    Attributes:
        at: From the trial's start, without pauses [s].
        what: Its kind.
        number: Counts its kind in the trial, from 1.
    """

    at: float
    what: str
    number: int


class Schedule:
    """What is due in a trial; pauses stop its clock."""

    def __init__(self, step: Step, now: float) -> None:
        """Begin a trial now [s]."""
        self._begun = now
        self._paused_s = 0.0
        self._paused_at: float | None = None
        kinds: Mapping[str, tuple[float, ...]] = {
            FREEZE: step.freezes,
            WITHHOLD: step.withheld,
            QUESTION: step.questions,
        }
        items = (
            Due(at=at, what=what, number=number)
            for what, moments in kinds.items()
            for number, at in enumerate(moments, 1)
        )
        self._waiting = deque(sorted(items, key=lambda item: item.at))

    def elapsed(self, now: float) -> float:
        """Time of the trial, without pauses [s]."""
        until = now if self._paused_at is None else self._paused_at
        return until - self._begun - self._paused_s

    def moment(self, elapsed: float, pauses: Sequence[tuple[float, float]]) -> float:
        """When a time of the trial was [s, monotonic clock].

        Args:
            elapsed: From the trial's start, without pauses [s].
            pauses: Begin and end of each pause on that clock [s], ascending.
        """
        moment = self._begun + elapsed
        for first, last in pauses:
            if self._begun <= first < moment:
                moment += last - first
        return moment

    def due(self, now: float, *, withheld: bool = False) -> list[Due]:
        """What begins now; each comes once, and none during a pause.

        Args:
            now: The time now [s].
            withheld: Whether control is withheld; a freeze waits for its end, as it would end the
                work that is measured.
        """
        if self._paused_at is not None:
            return []
        over = [each for each in self._waiting if each.at <= self.elapsed(now)]
        found = [each for each in over if not (withheld and each.what == FREEZE)]
        for each in found:
            self._waiting.remove(each)
        return found

    def pause(self, now: float) -> None:
        """Stop the clock; a second call has no effect."""
        if self._paused_at is None:
            self._paused_at = now

    def go_on(self, now: float) -> None:
        """Let the clock run again."""
        if self._paused_at is not None:
            self._paused_s += now - self._paused_at
            self._paused_at = None
