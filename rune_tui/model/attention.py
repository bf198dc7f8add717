"""The queue of the problems of all robots, in the order in which they need the operator; pure.

There is one entry for each cause at each robot. A robot is looked at while it is the chosen one, or
while the operator peeks at it.

| an entry | event | action |
| --- | --- | --- |
| is new | its robot is not looked at | raise it |
| is new | its robot is looked at | raise and answer it |
| is raised | its robot is looked at | answer it |
| is raised | 10 s pass | raise it again |
| is raised or answered | a warning becomes an alarm for the first time | raise it again |
| is raised or answered | the problem ends | leave it out, and remember it for 10 s |
| is remembered | the problem is back | show it as it was |

Alarms come before warnings, and older entries before newer ones. The order changes at most once per
second, so that a row that the operator reads stays where it is.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Sequence
from typing import Final

from hub.values import dataclass

AGAIN_S: Final = 10.0
"""Time after which an entry without an answer is raised again [s]."""
KEPT_S: Final = 10.0
"""Time for which a problem that ended is remembered [s]."""
ORDER_S: Final = 1.0
"""Shortest time between two changes of the order [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """A problem of a robot now.

    Attributes:
        robot: The robot's name in the layout.
        cause: Its cause, which stays while the words change.
        text: The words.
        alarm: Whether the operator must act; else it is a warning.
    """

    robot: str
    cause: str
    text: str
    alarm: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class AttentionEntry:
    """An entry of the queue.

    Attributes:
        robot: The robot's name in the layout.
        cause: The cause.
        text: The words.
        alarm: Whether the operator must act; else it is a warning.
        since: Time at which it was raised first, on the console's monotonic clock [s].
        raised: Time at which it was raised last, on the same clock [s].
        times: How often it was raised.
        answered: Whether the operator looked at the robot since then.
        over: Whether the problem has ended, and the entry goes with the next change of the order.
    """

    robot: str
    cause: str
    text: str
    alarm: bool
    since: float
    raised: float
    times: int
    answered: bool
    over: bool


@dataclass(slots=True)
class _Known:
    """What is remembered of a cause at a robot."""

    problem: Problem
    since: float
    raised: float
    times: int = 1
    answered: bool = False
    was_alarm: bool = False
    """Whether it was an alarm at any time."""
    ended: float = math.inf
    """Time at which the problem ended [s]; infinite: it is there."""

    @property
    def there(self) -> bool:
        """Whether the problem is there now."""
        return math.isinf(self.ended)

    def entry(self) -> AttentionEntry:
        """The entry that is shown."""
        problem = self.problem
        return AttentionEntry(
            robot=problem.robot,
            cause=problem.cause,
            text=problem.text,
            alarm=problem.alarm,
            since=self.since,
            raised=self.raised,
            times=self.times,
            answered=self.answered,
            over=not self.there,
        )


class AttentionQueue:
    """Follows the problems of all robots; the clock is passed in."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, str], _Known] = {}
        self._order: tuple[tuple[str, str], ...] = ()
        self._ordered = -math.inf

    def copied(self) -> AttentionQueue:
        """A queue with the same memory, which goes on by itself."""
        twin = copy.copy(self)
        twin._known = {key: copy.copy(known) for key, known in self._known.items()}  # noqa: SLF001
        return twin

    def look(
        self, problems: Iterable[Problem], seen: str, now: float
    ) -> tuple[AttentionEntry, ...]:
        """The queue now.

        Args:
            problems: All problems now.
            seen: The robot that the operator looks at.
            now: The time [s].
        """
        there: dict[tuple[str, str], Problem] = {}
        for problem in problems:
            key = problem.robot, problem.cause
            if key not in there or problem.alarm > there[key].alarm:
                there[key] = problem
        for key, known in self._known.items():
            if key not in there and known.there:
                known.ended = now
        self._known = {
            key: known for key, known in self._known.items() if now - known.ended < KEPT_S
        }
        for key, problem in there.items():
            self._update(key, problem, now)
            if problem.robot == seen:
                self._known[key].answered = True
        order = tuple(sorted(there, key=self._rank))
        if order != self._order and now - self._ordered >= ORDER_S:
            self._order, self._ordered = order, now
        return tuple(self._known[key].entry() for key in self._order if key in self._known)

    def _update(self, key: tuple[str, str], problem: Problem, now: float) -> None:
        """Raise a problem if it is new, worse than ever, or without an answer for too long."""
        known = self._known.get(key)
        if known is None:
            self._known[key] = _Known(problem, now, now, was_alarm=problem.alarm)
            return
        late = not known.answered and now - known.raised >= AGAIN_S
        if late or (problem.alarm and not known.was_alarm):
            known.raised, known.times, known.answered = now, known.times + 1, False
        known.problem, known.ended = problem, math.inf
        known.was_alarm = known.was_alarm or problem.alarm

    def _rank(self, key: tuple[str, str]) -> tuple[bool, float]:
        known = self._known[key]
        return not known.problem.alarm, known.since


def next_robot(queue: Sequence[AttentionEntry], chosen: str) -> str:
    """The robot that needs the operator next, apart from the chosen one; empty: none.

    That is the robot of the first entry without an answer. If all have one, it is the next robot
    of the queue after the chosen one, from its end to its begin.
    """
    there = [entry for entry in queue if not entry.over]
    others = [entry.robot for entry in there if entry.robot != chosen and not entry.answered]
    if others:
        return others[0]
    robots = list(dict.fromkeys(entry.robot for entry in there))
    first = robots.index(chosen) + 1 if chosen in robots else 0
    return next((each for each in (*robots[first:], *robots[:first]) if each != chosen), "")
