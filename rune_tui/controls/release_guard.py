"""After a stop: which keys must be released before a key drives again; pure.

A finger that was down at a stop must not move the robot again. The same holds for a hand-over of
control, a silence and a loss of the focus. After these, no key drives until all keys that may be
down were seen up. `TABLE` below is the rule. Its states and events:

| state | meaning |
| --- | --- |
| FREE | a press drives |
| WAITING | no press drives: keys that may be down must be released first |
| READY | all keys are up; without reported releases, the next press must be proven |
| PROVING | a key came; it drives if no repeat follows soon, because a key that is down repeats |

| event | terminal | meaning |
| --- | --- | --- |
| STOP_DOWN | any | a stop or another reason above; a key may be down, or on the line |
| STOP_UP | any | the same; no key is seen to be down |
| KEY | reports no releases | a press or a repeat: they are the same report |
| PRESS, LAST_PRESS | reports releases | a press; LAST: no other key is waited for |
| REPEAT | reports releases | a repeat of a key that does not drive |
| RELEASE, LAST_RELEASE | reports releases | a key that does not drive went up |
| QUIET | any | no key came for the time below |

| state | terminal | time after the last key |
| --- | --- | --- |
| WAITING | reports no releases, the last key repeated | `QUIET_S` |
| WAITING | reports no releases, the last key did not | `FIRST_QUIET_S` |
| WAITING | reports releases | never: only a release or a new press ends it |
| PROVING | answers | `PROOF_S` |
| PROVING | does not answer, or a multiplexer answers for it | `SLOW_PROOF_S` |

A terminal that answers sends its keys and its answers in order. So no key was pressed between the
last key and the last answered question, however slow the line is. On other terminals, the time
since the last key counts. For the same reason WAITING lasts until the terminal answers a question
that was asked after the stop: until then, keys from before the stop may arrive.
"""

from __future__ import annotations

import enum
import math
from collections import deque
from collections.abc import Mapping
from enum import auto
from typing import Final

QUIET_S: Final = 0.7
"""Keys are up after this time without a key [s]; keyboards repeat every 0.02 to 0.125 s."""
FIRST_QUIET_S: Final = 1.1
"""The same for a key that has not repeated yet [s]; keyboards wait up to 1 s before that."""
_REPEATS_S: Final = 0.2
"""Largest time between two repeats [s]; keys typed very fast come as close."""
_REPEATS: Final = 3
"""This number of them in a row are repeats."""
PROOF_S: Final = 0.15
"""A key that is down repeats within this time [s]; a press repeats after 0.2 s or more."""
SLOW_PROOF_S: Final = 0.45
"""The same where the line may delay a key by up to 0.3 s [s]."""
_SLOWEST_REPEAT_S: Final = 0.15
"""A new press repeats later than this; a key that is down already repeats sooner [s]."""
_SETTLED_S: Final = 0.02
"""Largest time from reading a key to handling it [s]."""
_ANSWERS_KEPT: Final = 8


class GuardState(enum.Enum):
    """Whether a press drives; see the tables of the module."""

    FREE = auto()
    WAITING = auto()
    READY = auto()
    PROVING = auto()


class GuardEvent(enum.Enum):
    """An event; see the tables of the module."""

    STOP_DOWN = auto()
    STOP_UP = auto()
    KEY = auto()
    PRESS = auto()
    LAST_PRESS = auto()
    REPEAT = auto()
    RELEASE = auto()
    LAST_RELEASE = auto()
    QUIET = auto()


class GuardAction(enum.Enum):
    """The effect on the key.

    Attributes:
        NOTHING: None.
        DRIVE: It drives.
        HOLD_BACK: It does not drive; it must be released first.
        PROVE: It does not drive yet; it must be proven.
        PROVEN: The key in proof drives now.
    """

    NOTHING = auto()
    DRIVE = auto()
    HOLD_BACK = auto()
    PROVE = auto()
    PROVEN = auto()


_S, _E, _A = GuardState, GuardEvent, GuardAction

TABLE: Final[Mapping[tuple[GuardState, GuardEvent], tuple[GuardAction, GuardState]]] = {
    (_S.FREE, _E.STOP_DOWN): (_A.NOTHING, _S.WAITING),
    (_S.FREE, _E.STOP_UP): (_A.NOTHING, _S.READY),
    (_S.FREE, _E.KEY): (_A.DRIVE, _S.FREE),
    (_S.FREE, _E.PRESS): (_A.DRIVE, _S.FREE),
    (_S.FREE, _E.LAST_PRESS): (_A.DRIVE, _S.FREE),
    (_S.FREE, _E.REPEAT): (_A.HOLD_BACK, _S.WAITING),
    (_S.FREE, _E.RELEASE): (_A.NOTHING, _S.FREE),
    (_S.FREE, _E.LAST_RELEASE): (_A.NOTHING, _S.FREE),
    (_S.FREE, _E.QUIET): (_A.NOTHING, _S.FREE),
    (_S.WAITING, _E.STOP_DOWN): (_A.NOTHING, _S.WAITING),
    (_S.WAITING, _E.STOP_UP): (_A.NOTHING, _S.WAITING),
    (_S.WAITING, _E.KEY): (_A.HOLD_BACK, _S.WAITING),
    (_S.WAITING, _E.PRESS): (_A.HOLD_BACK, _S.WAITING),
    (_S.WAITING, _E.LAST_PRESS): (_A.DRIVE, _S.FREE),
    (_S.WAITING, _E.REPEAT): (_A.HOLD_BACK, _S.WAITING),
    (_S.WAITING, _E.RELEASE): (_A.NOTHING, _S.WAITING),
    (_S.WAITING, _E.LAST_RELEASE): (_A.NOTHING, _S.FREE),
    (_S.WAITING, _E.QUIET): (_A.NOTHING, _S.READY),
    (_S.READY, _E.STOP_DOWN): (_A.NOTHING, _S.WAITING),
    (_S.READY, _E.STOP_UP): (_A.NOTHING, _S.READY),
    (_S.READY, _E.KEY): (_A.PROVE, _S.PROVING),
    (_S.READY, _E.PRESS): (_A.HOLD_BACK, _S.WAITING),
    (_S.READY, _E.LAST_PRESS): (_A.DRIVE, _S.FREE),
    (_S.READY, _E.REPEAT): (_A.HOLD_BACK, _S.WAITING),
    (_S.READY, _E.RELEASE): (_A.NOTHING, _S.READY),
    (_S.READY, _E.LAST_RELEASE): (_A.NOTHING, _S.READY),
    (_S.READY, _E.QUIET): (_A.NOTHING, _S.READY),
    (_S.PROVING, _E.STOP_DOWN): (_A.NOTHING, _S.WAITING),
    (_S.PROVING, _E.STOP_UP): (_A.NOTHING, _S.WAITING),
    (_S.PROVING, _E.KEY): (_A.HOLD_BACK, _S.WAITING),
    (_S.PROVING, _E.PRESS): (_A.HOLD_BACK, _S.WAITING),
    (_S.PROVING, _E.LAST_PRESS): (_A.HOLD_BACK, _S.WAITING),
    (_S.PROVING, _E.REPEAT): (_A.HOLD_BACK, _S.WAITING),
    (_S.PROVING, _E.RELEASE): (_A.NOTHING, _S.PROVING),
    (_S.PROVING, _E.LAST_RELEASE): (_A.NOTHING, _S.PROVING),
    (_S.PROVING, _E.QUIET): (_A.PROVEN, _S.FREE),
}
"""For each state and event: the effect on the key, and the next state."""


class ReleaseGuard:
    """Follows `TABLE`, for keys that drive; the clock is passed in.

    Attributes:
        state: The present state.
        answers: Whether the terminal itself answers questions, so that quiet can be proven.
        hasty: Whether the last press repeated before it was proven: only a tap can be proven.
    """

    def __init__(self) -> None:
        self.state = GuardState.FREE
        self.answers = False
        self.hasty = False
        self._down: set[str] = set()
        """Keys that are down, by reports of the terminal."""
        self._reported: set[str] = set()
        """Those of them that must be released first."""
        self._timed: set[str] = set()
        """Keys without reported releases that must be released first."""
        self._repeats = 0
        self._needed = QUIET_S
        self._stopped = -math.inf
        """Time of the last stop [s]."""
        self._candidate = ""
        self._last = -math.inf
        """Time of the last key [s]."""
        self._came: dict[str, float] = {}
        """Time of the last report of each key without reported releases [s]."""
        self._answered: deque[tuple[float, float]] = deque(maxlen=_ANSWERS_KEPT)

    @property
    def waited_for(self) -> tuple[str, ...]:
        """Keys that must be released before a key drives."""
        if self.state is not GuardState.WAITING:
            return ()
        return tuple(sorted(self._reported | self._timed))

    @property
    def hurries(self) -> bool:
        """Whether a key waits for the next answer of the terminal to drive."""
        proving = self.state is GuardState.PROVING
        return proving or (self.state is GuardState.WAITING and self._outstanding)

    @property
    def needs_answers(self) -> bool:
        """Whether an answer of the terminal can show that keys are up."""
        return self.state in {GuardState.WAITING, GuardState.PROVING}

    def stop(self, keys: set[str] | None, now: float) -> None:
        """Take a stop: those of these keys that may be down must be released.

        Args:
            keys: The keys that drive the stopped robot; None: all.
            now: The time [s].
        """
        reported = {key for key in self._down if keys is None or key in keys}
        timed = {
            key
            for key, last in self._came.items()
            if (keys is None or key in keys) and not self.quiet(last, self._needed, now)
        }
        self._reported |= reported
        self._timed |= timed
        self._stopped = now
        down = reported or timed or self._outstanding
        self._follow(GuardEvent.STOP_DOWN if down else GuardEvent.STOP_UP)

    def key(self, key: str, read: float) -> GuardAction:
        """Take a key that drives, from a terminal that reports no releases.

        Args:
            key: Its name.
            read: The time at which it was read [s].
        """
        again = self.state is GuardState.PROVING and key == self._candidate
        self.hasty = self.hasty or (again and read - self._last > _SLOWEST_REPEAT_S)
        self.saw(key, read)
        action = self._follow(GuardEvent.KEY)
        if action is GuardAction.HOLD_BACK:
            self._timed.add(key)
        elif action is GuardAction.PROVE:
            self._candidate = key
        return action

    def saw(self, key: str, read: float) -> None:
        """The same for a repeat of a key that is HELD."""
        again = read - self._came.get(key, -math.inf) < _REPEATS_S
        self._repeats = self._repeats + 1 if again else 0
        self._needed = QUIET_S if self._repeats >= _REPEATS else FIRST_QUIET_S
        self._last = read
        self._came[key] = read

    def press(self, key: str, now: float) -> GuardAction:
        """Take a press of a key that drives, from a terminal that reports releases."""
        self._reported.discard(key)
        self._last = now
        action = self._follow(self._last_or(GuardEvent.LAST_PRESS, GuardEvent.PRESS))
        self._down.add(key)
        if action is GuardAction.HOLD_BACK:
            self._reported.add(key)
        return action

    def repeat(self, key: str, now: float, *, drives: bool) -> None:
        """Take a repeat of a key that drives, from a terminal that reports releases.

        Args:
            key: Its name.
            now: The time [s].
            drives: Whether it is HELD.
        """
        self._down.add(key)
        self._last = now
        if not drives:
            self._reported.add(key)
            self._follow(GuardEvent.REPEAT)

    def release(self, key: str) -> None:
        """Take a release."""
        self._down.discard(key)
        if key in self._reported:
            self._reported.discard(key)
            self._follow(self._last_or(GuardEvent.LAST_RELEASE, GuardEvent.RELEASE))

    def resume(self) -> None:
        """Live repeats show that a finger is down and may drive again."""
        self._timed.clear()
        self._reported.clear()
        self.state = GuardState.FREE
        self.hasty = False

    def heard(self, now: float, asked: float) -> None:
        """Take an answer of the terminal.

        Args:
            now: The time at which it was read [s].
            asked: The time at which its question was written [s].
        """
        self._answered.append((now, asked))

    def update(self, now: float) -> str:
        """Apply the time limits; returns the key that is proven now and drives, or ""."""
        if self.state is GuardState.PROVING:
            if self.quiet(self._last, self.proof_s, now):
                self._follow(GuardEvent.QUIET)
                return self._candidate
        elif self.state is GuardState.WAITING:
            quiet = not self._timed or self.quiet(self._last, self._needed, now)
            if quiet and not (self._reported or self._outstanding):
                self._follow(GuardEvent.QUIET)
        return ""

    @property
    def proof_s(self) -> float:
        """Time without a report that proves a press [s]."""
        return PROOF_S if self.answers else SLOW_PROOF_S

    def quiet(self, since: float, needed: float, now: float) -> bool:
        """Whether no key came for the needed time after a moment [s]."""
        if not self.answers:
            return now - _SETTLED_S - since >= needed
        settled = (asked for read, asked in self._answered if now - read >= _SETTLED_S)
        return max(settled, default=-math.inf) - since >= needed

    def _follow(self, event: GuardEvent) -> GuardAction:
        action, self.state = TABLE[self.state, event]
        if self.state is not GuardState.WAITING:
            self._reported.clear()
            self._timed.clear()
        self.hasty = self.hasty and self.state is not GuardState.FREE
        return action

    def _last_or(self, last: GuardEvent, other: GuardEvent) -> GuardEvent:
        return other if self._reported or self._timed or self._outstanding else last

    @property
    def _outstanding(self) -> bool:
        """Whether keys from before the last stop may still be on the line."""
        return self.answers and all(asked < self._stopped for _, asked in self._answered)
