"""The goals that a hub sent to a robot's own navigation, and those that must end; pure.

The hub has one goal at a time. Goals that must end are unwanted: each is cancelled at once, and
again every second, until the robot says that it has ended.

| goal | event | action | next |
| --- | --- | --- | --- |
| none | a new one, and no goal is unwanted | send it | SENT |
| none | a new one, and one is unwanted | wait for its end | SENT |
| any | a new one, and the action is away | none | REFUSED |
| SENT | the robot takes it, or lists it | none | DRIVES |
| SENT | the robot does not take it | none | REFUSED |
| SENT | no answer for 2 s, or the call failed | unwanted | LOST |
| SENT, DRIVES | its status is an end | none | REACHED, ABORTED, CANCELLED |
| SENT, DRIVES | `end`, or another goal | unwanted | CANCELLED |
| DRIVES | nothing heard of it for 3 s, or the robot lists it no more | unwanted | LOST |
| SENT, DRIVES | the line or the action goes away | unwanted, cancelled after the return | LOST |
| any | the robot lists a goal of this hub that is not the present one | unwanted | as before |
| any | the robot takes a goal that was unwanted already | unwanted | as before |
| any | `stop` | cancel every goal; those of others are unwanted too | CANCELLED |

| unwanted goal | event | next |
| --- | --- | --- |
| any | its status is an end; the robot does not know it | it has ended |
| was listed | the robot lists it no more | it has ended |
| was not listed | the robot does not list it, 1 s after the cancel | it has ended |
| any | 1 s without its end | cancelled again, and `unanswered` |

No goal is sent a second time. Of a goal that was aborted without a reason, the reason is asked
for once, after all that was due; it changes words only.
"""

from __future__ import annotations

import math
import secrets
from collections.abc import Iterable
from typing import Final, Protocol

from hub.gcm.own_navigation import OwnGoal
from hub.ros.goal_messages import EVERY_GOAL, CancelAnswer, GoalPlace, GoalStatus, KnownGoal
from hub.values import dataclass

ANSWER_S: Final = 2.0
"""Longest time until the robot takes a goal [s]."""
SILENT_S: Final = 3.0
"""Time without a message about the goal after which it is cancelled [s]."""
CANCEL_AGAIN_S: Final = 1.0
"""Time from a cancel to the next one of the same goal [s]."""
_NAME_BYTES: Final = 16
_ENDS: Final = {
    GoalStatus.REACHED: (OwnGoal.REACHED, ""),
    GoalStatus.ABORTED: (OwnGoal.ABORTED, "the robot's own navigation gave up"),
    GoalStatus.CANCELLED: (OwnGoal.CANCELLED, "another node ended it"),
    GoalStatus.REFUSED: (OwnGoal.REFUSED, "the robot's own navigation refuses it"),
}


class GoalPort(Protocol):
    """The way to the robot's own navigation."""

    def send(self, name: str, place: GoalPlace) -> bool:
        """Send a goal; returns whether it left."""

    def cancel(self, name: str) -> bool:
        """Cancel a goal, or `EVERY_GOAL`; returns whether that left."""

    def explain(self, name: str) -> bool:
        """Ask why a goal was aborted; returns whether that left, or cannot be asked."""


@dataclass(slots=True, kw_only=True, eq=False)
class _Sent:
    """The present goal: its name, when it was sent, when it was heard of, whether it was listed."""

    name: str
    sent_at: float
    heard_at: float
    taken: bool = False
    listed: bool = False


@dataclass(slots=True, kw_only=True, eq=False)
class _Unwanted:
    """A goal that must end: since when, when it was cancelled last, whether it was listed."""

    since: float
    asked_at: float = -math.inf
    listed: bool = False


class GoalKeeper:
    """The goals of one hub at one robot; every method gets the monotonic time [s].

    Attributes:
        number: Number of the last goal; 0: there was none.
        state: Its state.
        why: The reason of its end, for people.
        left: The way that is left [m]; NaN: not known.
    """

    def __init__(self, port: GoalPort, tag: str) -> None:
        """Have no goal.

        Args:
            port: Sends and cancels.
            tag: First hexadecimal digits of the names of this hub's goals, also of the process
                before this one.
        """
        self.number = 0
        self.state = OwnGoal.NONE
        self.why = ""
        self.left = math.nan
        self._port, self._tag = port, tag
        self._ready = False
        self._sent: _Sent | None = None
        self._waiting: GoalPlace | None = None
        self._unwanted: dict[str, _Unwanted] = {}
        self._known: dict[str, KnownGoal] = {}
        self._aborted = self._unexplained = ""

    @property
    def drives(self) -> bool:
        """Whether the robot may drive to the present goal, so that no velocity is sent."""
        return self._sent is not None

    @property
    def others(self) -> tuple[KnownGoal, ...]:
        """Goals of other nodes that have not ended."""
        return tuple(
            each
            for each in self._known.values()
            if not each.status.ended and not each.name.startswith(self._tag)
        )

    @property
    def ending(self) -> bool:
        """Whether a goal that must end has not ended yet."""
        return bool(self._unwanted)

    def settled(self, now: float) -> bool:
        """Whether velocities may follow: no goal is being cancelled, or none ended in time."""
        return not self._unwanted or self.unanswered(now)

    def unanswered(self, now: float) -> bool:
        """Whether a cancelled goal did not end in time."""
        return any(now - each.since >= CANCEL_AGAIN_S for each in self._unwanted.values())

    def heard_s(self, now: float) -> float:
        """Age of the last message about the present goal [s]; NaN: there is none."""
        return now - self._sent.heard_at if self._sent is not None else math.nan

    def go(self, number: int, place: GoalPlace, now: float) -> None:
        """Drive to a place; a number that is known changes nothing."""
        if number == self.number:
            return
        self._withdraw(OwnGoal.CANCELLED, "another goal came", now)
        self.number, self.state, self.why, self.left = number, OwnGoal.SENT, "", math.nan
        self._waiting = place
        self.advance(now)

    def end(self, now: float) -> None:
        """Drive there no more."""
        if self._waiting is not None:
            self._waiting = None
            self.state, self.why = OwnGoal.CANCELLED, ""
        self._withdraw(OwnGoal.CANCELLED, "", now)
        self.advance(now)

    def stop(self, now: float) -> None:
        """End every goal, also of other nodes."""
        self.end(now)
        for each in self.others:
            self._unwanted.setdefault(each.name, _Unwanted(since=now, asked_at=now, listed=True))
        if self._ready:
            self._port.cancel(EVERY_GOAL)

    def reach(self, now: float, *, ready: bool) -> None:
        """Note whether the action can be reached."""
        if self._ready and not ready:
            self._withdraw(OwnGoal.LOST, "the robot's own navigation cannot be reached", now)
            self._known.clear()
            self._unexplained = ""
            for each in self._unwanted.values():
                each.asked_at, each.listed = -math.inf, False
        self._ready = ready

    def taken(self, name: str, now: float) -> None:
        """The robot takes a goal."""
        if self._sent is not None and self._sent.name == name:
            self._sent.taken, self._sent.heard_at = True, now
            self.state = OwnGoal.DRIVES
        else:
            self._unwanted.setdefault(name, _Unwanted(since=now))

    def refused(self, name: str) -> None:
        """The robot does not take a goal."""
        self._unwanted.pop(name, None)
        if self._sent is not None and self._sent.name == name:
            self._finish(GoalStatus.REFUSED, "")

    def failed(self, name: str, why: str, now: float) -> None:
        """A goal was not answered, for a reason."""
        if self._sent is not None and self._sent.name == name and not self._sent.taken:
            self._withdraw(OwnGoal.LOST, why, now)

    def cancelled(self, name: str, answer: CancelAnswer) -> None:
        """The robot answers a cancel; that it begins is no end yet."""
        if answer in (CancelAnswer.UNKNOWN, CancelAnswer.ENDED):
            self._unwanted.pop(name, None)

    def explained(self, name: str, why: str) -> None:
        """The robot says why it aborted a goal."""
        if why and name == self._aborted and self.state is OwnGoal.ABORTED:
            self.why = f"{_ENDS[GoalStatus.ABORTED][1]}: {why}"

    def moved(self, name: str, left: float, now: float) -> None:
        """A goal goes on, with the way that is left [m]."""
        if self._sent is not None and self._sent.name == name:
            self._sent.heard_at, self.left = now, left

    def listed(self, goals: Iterable[KnownGoal], now: float) -> None:
        """The robot lists its goals."""
        self._known = {each.name: each for each in goals}
        self._look_at_sent(now)
        present = self._sent.name if self._sent is not None else ""
        for name, each in self._known.items():
            unwanted = self._unwanted.get(name)
            if each.status.ended:
                self._unwanted.pop(name, None)
            elif unwanted is not None:
                unwanted.listed = True
            elif name != present and name.startswith(self._tag):
                self._unwanted[name] = _Unwanted(since=now, listed=True)
        for name, gone in tuple(self._unwanted.items()):
            late = now - gone.asked_at >= CANCEL_AGAIN_S and gone.asked_at > -math.inf
            if name not in self._known and (gone.listed or late):
                del self._unwanted[name]

    def advance(self, now: float) -> None:
        """Send what is due."""
        sent = self._sent
        if not self._ready:
            if self._waiting is not None:
                self._waiting = None
                why = "the robot's own navigation cannot be reached"
                self.state, self.why = OwnGoal.REFUSED, why
            return
        if sent is not None and not sent.taken and now - sent.sent_at >= ANSWER_S:
            self._withdraw(OwnGoal.LOST, "the robot's own navigation does not answer", now)
        elif sent is not None and now - sent.heard_at >= SILENT_S:
            why = f"the robot's own navigation was silent for {SILENT_S:.0f} s"
            self._withdraw(OwnGoal.LOST, why, now)
        for name, each in self._unwanted.items():
            if now - each.asked_at >= CANCEL_AGAIN_S and self._port.cancel(name):
                each.asked_at = now
        if self._waiting is not None and not self._unwanted:
            self._send(self._waiting, now)
        if self._unexplained and self._port.explain(self._unexplained):
            self._unexplained = ""

    def _send(self, place: GoalPlace, now: float) -> None:
        name = self._tag + secrets.token_hex(_NAME_BYTES - len(self._tag) // 2)
        self._waiting = None
        # The answer may come before `send` returns.
        self._sent = _Sent(name=name, sent_at=now, heard_at=now)
        if not self._port.send(name, place):
            self._sent = None
            self.state, self.why = OwnGoal.REFUSED, "the line to the robot takes nothing now"

    def _look_at_sent(self, now: float) -> None:
        sent = self._sent
        if sent is None:
            return
        found = self._known.get(sent.name)
        if found is None:
            if sent.listed:
                sent.listed = False  # it is cancelled too: this list may be wrong
                self._withdraw(OwnGoal.LOST, "the robot's own navigation began again", now)
        elif found.status.ended:
            if found.status is GoalStatus.ABORTED and not found.text:
                self._aborted = self._unexplained = sent.name
            self._finish(found.status, found.text)
        else:
            sent.listed = sent.taken = True
            sent.heard_at, self.state = now, OwnGoal.DRIVES

    def _finish(self, status: GoalStatus, text: str) -> None:
        self.state, self.why = _ENDS[status]
        if text and self.why:
            self.why = f"{self.why}: {text}"
        self._sent, self.left = None, math.nan

    def _withdraw(self, state: OwnGoal, why: str, now: float) -> None:
        """The present goal becomes unwanted, if there is one."""
        if self._sent is not None:
            self._unwanted[self._sent.name] = _Unwanted(since=now, listed=self._sent.listed)
            self._sent, self.left = None, math.nan
            self.state, self.why = state, why
