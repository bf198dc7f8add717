"""Which keys count as held down, with and without reported releases; pure.

A key drives while it is HELD. `release_guard` says whether a press drives at all: not after a stop,
before all keys that may be down were seen up. This is what becomes of one key:

| state | event | terminal reports releases | it does not |
| --- | --- | --- | --- |
| up | press, the guard lets it drive | HELD | HELD for 0.6 s |
| up | press, the guard does not | MUST BE RELEASED | MUST BE RELEASED, or proven first |
| up | repeat | MUST BE RELEASED | looks like a press |
| HELD | repeat | HELD | HELD for 2.5 repeat intervals, 0.15 to 0.6 s |
| HELD | release | up | not reported |
| HELD | no repeats for that time | see below | up |
| HELD | two repeats at once with their press | HELD | MUST BE RELEASED: it is late |
| HELD | a stop that concerns it | MUST BE RELEASED | MUST BE RELEASED |
| HELD | focus lost, and the like | up, and it must be released | the same |
| MUST BE RELEASED | release | up | not reported |
| MUST BE RELEASED | press | HELD, if the guard lets it | looks like a repeat |
| MUST BE RELEASED | repeat | MUST BE RELEASED | the same; three live ones after a pause: HELD |
| any | Super or Cmd goes down | up | not reported |

A release is lost when a window manager or another window takes it. So where releases are reported,
silence ends a hold too: 0.6 s after the terminal was heard last, 0.6 s after the last repeat of the
key that repeated last of all keys, and 5 s after any key moved for all other keys.

No keyboard repeats at once: repeats that come together with their press were late, and the finger
may be up. Live repeats come as far apart as before. Three of them show that a finger is down now,
within 1 s of a pause of the line and without a stop in between.
"""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from rune_tui.controls.events import ControlEvent
from rune_tui.controls.release_guard import GuardAction, GuardState, ReleaseGuard
from rune_tui.layout.names import canonical_key

FIRST_HOLD_S = 0.6
"""How long a first press holds, and the longest that anything holds [s]."""
_LEAST_HOLD_S = 0.15
"""How long a repeat holds at least [s]."""
_REPEAT_FACTOR = 2.5
"""How many repeat intervals a repeat holds."""
_REPEATS_MEASURED = 6
_BURST_S = 0.01
"""Repeats closer than this came together over a slow line and say nothing of the rate [s]."""
_SILENT_S = 5.0
"""How long a key is held whose release would be reported while no key moves at all [s]."""
_GRABS = "super"
"""Part of the names of keys with which window managers, and macOS with Cmd, take what follows."""
_LATE_REPEATS = 2
"""So many of them right behind the press show that it is late; two quick taps look like one."""
_RESUMES_S = 1.0
"""The longest pause of the line after which a key that is still down drives on [s]."""
_LIVE_REPEATS = 3
"""So many in a row, none sooner than keyboards have them, show that a finger is on the key now."""
_LIVE_SHARE = 0.6
"""The share of the repeat interval from which on a repeat counts as no sooner."""


def name_of_key(key: str, character: str | None) -> str:
    """The name under which layouts know a key.

    Args:
        key: What the terminal library calls it, such as "plus", "up" or "W".
        character: The printable character it types, if any.
    """
    chord = not {"shift"}.issuperset(key.split("+")[:-1])
    if chord or character is None or len(character) != 1 or not character.isprintable():
        return canonical_key(key)
    return canonical_key(character)


def without_shift(key: str, character: str | None) -> str:
    """The name that a key has without Shift; empty if Shift is not held with it.

    Args:
        key: As of `name_of_key`.
        character: As of `name_of_key`.
    """
    *modifiers, last = key.split("+") if len(key) > 1 else [key]
    if modifiers == ["shift"]:
        return canonical_key(last)
    upper = character is not None and character.isalpha() and character.isupper()
    return canonical_key(character or "") if upper and not modifiers else ""


@dataclass(slots=True)
class _Hold:
    last: float
    deadline: float
    repeats: int = 0
    at_once: int = 0
    """Repeats that came together with the press."""
    must_release: bool = False
    fine: bool = False
    told: bool = False
    """Whether the terminal reports its release."""
    silent_at: float = math.inf
    """When it has been silent for so long that its release was lost, if it is reported [s]."""
    ended: bool = False
    """Whether its release was passed on, or is nobody's as its press was none."""
    live_from: float = math.inf
    """After a pause of the line: how far apart repeats are that are no sooner than before [s]."""
    live: int = 0
    """So many of those came in a row."""


class KeyboardHold:
    """Key presses and repeats in, presses, repeats and releases out; the clock is passed in.

    How fast the keyboard repeats is measured over its last few repeats, whatever the key. The
    longest of these intervals counts, because a slow line delivers repeats in bursts.

    Attributes:
        drives: Whether a key drives a robot; the guard is about those alone.
    """

    def __init__(self, drives: Callable[[str], bool] = lambda _: True) -> None:
        """Begin without any key.

        Args:
            drives: Whether a key drives a robot; the guard is about those alone.
        """
        self.drives = drives
        self._guard = ReleaseGuard()
        self._holds: dict[str, _Hold] = {}
        self._paused: dict[str, tuple[float, float]] = {}
        self._resumable = False
        self._intervals: deque[float] = deque(maxlen=_REPEATS_MEASURED)

    @property
    def held(self) -> tuple[str, ...]:
        """Keys that count as held, in the order they were pressed."""
        return tuple(key for key, hold in self._holds.items() if not hold.must_release)

    @property
    def must_release(self) -> tuple[str, ...]:
        """Keys that must be released before a key drives."""
        return self._guard.waited_for

    @property
    def tap_first(self) -> bool:
        """Whether a key that is held cannot drive before it was tapped: it repeats too soon."""
        return self._guard.hasty

    def press(
        self,
        key: str,
        now: float,
        *,
        read: float | None = None,
        fine: bool = False,
        stale: bool = False,
    ) -> tuple[ControlEvent, ...]:
        """The terminal reports a key: releases that were due by now, then its press or repeat.

        Args:
            key: What it is called.
            now: The time [s].
            read: When it was read, if that is not just now [s].
            fine: Whether Shift is held with it.
            stale: Whether it may have been typed while the console was away; it drives only when
                it is pressed anew.
        """
        key = canonical_key(key)
        read = now if read is None else read
        due = [*self._due(now), *self._proven(read)]
        hold = self._holds.get(key)
        if stale and self.drives(key):
            self._guard.saw(key, read)
            self._stop({key}, now)
        if hold is None:
            return (*due, self._first(key, read, now, fine=fine, stale=stale))
        live = self._is_live(hold, read)
        self._repeated(hold, read)
        hold.deadline = now + self._repeat_hold()
        if hold.must_release and live and self._resumable:
            self._guard.resume()
            hold.must_release = hold.ended = False
            hold.at_once, hold.live_from = 0, math.inf
            hold.fine = fine
            return (*due, self._proven_press(key, hold))
        if self.drives(key):
            if hold.must_release:
                self._guard.key(key, read)
            else:
                self._guard.saw(key, read)
        if hold.at_once >= _LATE_REPEATS and not hold.must_release:
            due += self._late(key, hold, now)
        return (
            *due,
            ControlEvent(
                name=key,
                pressed=True,
                repeat=True,
                fine=fine,
                timed=True,
                must_release_first=hold.must_release,
                stale=stale,
            ),
        )

    def down(
        self, key: str, now: float, *, repeat: bool, fine: bool = False, stale: bool = False
    ) -> tuple[ControlEvent, ...]:
        """A terminal that will report the release reports a key: its press, or a repeat.

        A repeat of a key that does not count as held was pressed before all were let go, before the
        terminal fell silent, or unseen: it is a repeat, never a press, and its release is nobody's.

        Args:
            key: What it is called.
            now: The time [s].
            repeat: Whether it is a repeat.
            fine: As of `press`.
            stale: As of `press`.
        """
        key = canonical_key(key)
        due = list(self.expire(now))
        hold = self._holds.get(key)
        if hold is not None and not repeat:
            due += self.up(key, now)  # which did not come
            hold = None
        if _GRABS in key and not repeat:
            due += self._lost()
        if hold is None:
            hold = self._holds[key] = _Hold(last=now, deadline=now, must_release=repeat, told=True)
        elif repeat:
            self._repeated(hold, now)
        self._guarded(key, hold, now, repeat=repeat)
        if stale and self.drives(key):
            self._stop({key}, now)
        hold.must_release = hold.must_release or stale
        hold.ended = hold.ended or stale or (repeat and hold.must_release)
        self.heard(now)
        self._moved(now, hold if repeat else None)
        return (
            *due,
            ControlEvent(
                name=key,
                pressed=True,
                repeat=repeat,
                fine=fine,
                must_release_first=hold.must_release,
                stale=stale,
            ),
        )

    def up(self, key: str, now: float) -> tuple[ControlEvent, ...]:
        """A key went up."""
        key = canonical_key(key)
        self._moved(now, None)
        self._guard.release(key)
        return self._ended((key,)) if key in self._holds else ()

    def heard(self, now: float, asked: float | None = None) -> None:
        """The terminal is there: keys whose release it will report stay held.

        Args:
            now: When that was read [s].
            asked: When the question was written that it answers, if it does [s].
        """
        if asked is not None:
            self._guard.heard(now, asked)
        for hold in self._holds.values():
            if hold.told:
                hold.deadline = max(hold.deadline, now + FIRST_HOLD_S)

    @property
    def needs_answers(self) -> bool:
        """Whether the terminal must be heard: keys are held, or waited for, until it answers."""
        return self._guard.needs_answers or any(hold.told for hold in self._holds.values())

    @property
    def hurries(self) -> bool:
        """Whether an answer of the terminal would soon let a key drive."""
        return self._guard.hurries

    @property
    def hold_s(self) -> float:
        """How long a repeat holds where no release is reported [s]."""
        return self._repeat_hold()

    @property
    def answers(self) -> bool:
        """Whether the terminal itself answers questions, in the order of its keys."""
        return self._guard.answers

    @answers.setter
    def answers(self, itself: bool) -> None:
        self._guard.answers = itself

    def expire(self, now: float) -> tuple[ControlEvent, ...]:
        """Releases that are due, the earliest first; then the press that is proven by now."""
        return (*self._due(now), *self._proven(now))

    def _due(self, now: float) -> tuple[ControlEvent, ...]:
        ends = ((min(hold.deadline, hold.silent_at), key) for key, hold in self._holds.items())
        due = sorted((end, key) for end, key in ends if end <= now)
        for _, key in due:
            hold = self._holds[key]
            if self._intervals and hold.repeats and not (hold.told or hold.must_release):
                usual = statistics.median(self._intervals)
                self._paused[key] = hold.last + _RESUMES_S, _LIVE_SHARE * usual
        return self._ended(key for _, key in due)

    def _proven(self, now: float) -> tuple[ControlEvent, ...]:
        key = self._guard.look(now)
        hold = self._holds.get(key)
        if hold is None:
            return ()
        hold.must_release = False
        hold.deadline = now + FIRST_HOLD_S  # as for a press that comes now
        return (self._proven_press(key, hold),)

    @staticmethod
    def _proven_press(key: str, hold: _Hold) -> ControlEvent:
        return ControlEvent(name=key, pressed=True, fine=hold.fine, timed=True, proven=True)

    def release_all(self, now: float) -> tuple[ControlEvent, ...]:
        """Everything is let go: the terminal lost the focus, was suspended, or the console ends."""
        self._stop(None, now)
        return self._ended(tuple(self._holds))

    def stop(self, keys: Iterable[str], now: float) -> None:
        """A robot was stopped or changed hands: keys that drive it and are down must be released.

        Args:
            keys: The keys that drive it.
            now: The time [s].
        """
        self._stop(set(keys), now)

    def _stop(self, keys: set[str] | None, now: float) -> None:
        self._resumable = False
        self._paused.clear()
        for key, hold in self._holds.items():
            hold.live_from = math.inf
            if keys is None or key in keys:
                hold.must_release = hold.must_release or self.drives(key)
        self._guard.stop(keys, now)

    def _first(self, key: str, read: float, now: float, *, fine: bool, stale: bool) -> ControlEvent:
        """A key came, on a terminal that reports no releases, that was not down."""
        hold = _Hold(last=read, deadline=now + FIRST_HOLD_S, ended=stale, fine=fine)
        hold.must_release = stale
        if self.drives(key):
            action = self._guard.key(key, read)
            hold.must_release = action is not GuardAction.DRIVE
        until, live_from = self._paused.pop(key, (read, math.inf))
        hold.live_from = math.inf if hold.must_release or read > until else live_from
        self._holds[key] = hold
        return ControlEvent(
            name=key,
            pressed=True,
            fine=fine,
            timed=True,
            must_release_first=hold.must_release,
            stale=stale,
        )

    def _late(self, key: str, hold: _Hold, now: float) -> tuple[ControlEvent, ...]:
        """Its repeats came at once with it: it drives no longer."""
        if not self.drives(key):
            return ()
        free = self._guard.state is GuardState.FREE
        self._guard.stop({key}, now)
        self._resumable = free or self._resumable
        hold.must_release = hold.ended = True
        return (ControlEvent(name=key, pressed=False),)

    def _guarded(self, key: str, hold: _Hold, now: float, *, repeat: bool) -> None:
        """Ask the guard about a key whose release will be reported."""
        if not self.drives(key):
            return
        if repeat:
            self._guard.repeat(key, now, drives=not hold.must_release)
        else:
            hold.must_release = self._guard.press(key, now) is not GuardAction.DRIVE

    def _is_live(self, hold: _Hold, read: float) -> bool:
        """Whether a key that was held before a pause of the line is seen to be down now."""
        hold.live = hold.live + 1 if read - hold.last >= hold.live_from else 0
        return hold.live >= _LIVE_REPEATS

    def _lost(self) -> tuple[ControlEvent, ...]:
        """Keys whose releases may be reported to somebody else from here on go up now."""
        told = [key for key, hold in self._holds.items() if hold.told]
        return self._ended(told)

    def _ended(self, keys: Iterable[str]) -> tuple[ControlEvent, ...]:
        ends = [(key, self._holds.pop(key)) for key in keys]
        return tuple(ControlEvent(name=key, pressed=False) for key, hold in ends if not hold.ended)

    def _moved(self, now: float, repeats: _Hold | None) -> None:
        """A key moved: none that is held needs to be heard of for a while.

        Args:
            now: The time [s].
            repeats: The one that repeats, if that is how it moved: it will go on to.
        """
        for hold in self._holds.values():
            if hold.told:
                hold.silent_at = now + _SILENT_S
        if repeats is not None and self._intervals:
            soon = max(FIRST_HOLD_S, _REPEAT_FACTOR * max(self._intervals))
            repeats.silent_at = now + min(_SILENT_S, soon)

    def _repeated(self, hold: _Hold, read: float) -> None:
        """Measure how fast the keyboard repeats, and what came all at once."""
        # Behind a pause of the line, all that comes faster than keys repeat was held back.
        together = read - hold.last < (hold.live_from if hold.live_from < math.inf else _BURST_S)
        if together and hold.at_once == hold.repeats:
            hold.at_once += 1
        # From press to first repeat is the keyboard's delay, which says nothing of its rate.
        if hold.repeats and not together:
            self._intervals.append(read - hold.last)
        hold.repeats += 1
        hold.last = read

    def _repeat_hold(self) -> float:
        if not self._intervals:
            return FIRST_HOLD_S
        return min(FIRST_HOLD_S, max(_LEAST_HOLD_S, _REPEAT_FACTOR * max(self._intervals)))
