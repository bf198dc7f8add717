"""Keys that count as held down, on terminals that tell when they go up and on those that do not.

Most terminals repeat a held key and say nothing when it goes up. So a key counts as held until its
repeats stay away: after the first press for as long as keyboards wait before they repeat, then
for a few repeat intervals. No keyboard repeats at once: repeats that come together with their press
were held back on the way. Such a key was pressed some time ago, and drives only when it is pressed
anew. But where a key was held until the line paused, for a second at most, and goes on to repeat as
fast as it did, the finger has been on it all the time: it drives on, unless the robot was stopped
or changed hands meanwhile.

Where the terminal tells of releases a key is held until its own, but only as long as anything is
heard of the terminal: over a line that is cut, no release comes. Nor does one come that somebody
else was given, as by a window manager or by Cmd on macOS. So silence ends a hold even while the
terminal answers. The key that went down last repeats for as long as it is down; once it has done so
and no other key moved since, it is up when its repeats stay away. Any other key may be down in
silence, as another one took its repeats or its keyboard has none, which is what driving with two
keys looks like: it stays held while keys move, whichever these are, and for some time after. The
key that window managers take, Super or Cmd, ends all holds when it goes down.
"""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.names import canonical_key

_FIRST_HOLD_S = 0.6
"""How long a first press holds, and the longest that anything holds [s]."""
_LEAST_HOLD_S = 0.15
"""How long a repeat holds at least [s]."""
_REPEAT_FACTOR = 2.5
"""How many repeat intervals a repeat holds."""
_REPEATS_MEASURED = 6
_BURST_S = 0.01
"""Repeats closer than this came together over a slow line and say nothing of the rate [s]."""
_SILENT_S = 5.0
"""How long a key is held whose release would be told while no key moves at all [s]."""
_GRABS = "super"
"""Part of the names of keys with which window managers, and macOS with Cmd, take what follows."""
_OLD_REPEATS = 2
"""So many of them right behind the press tell that it is old; two quick taps look like one."""

_RESUMES_S = 1.0
"""The longest pause of the line after which a key that is still down drives on [s]."""
_LIVE_REPEATS = 3
"""So many in a row, none sooner than keyboards have them, tell that a finger is on the key now."""
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


@dataclass(slots=True)
class _Hold:
    last: float
    deadline: float
    repeats: int = 0
    at_once: int = 0
    """Repeats that came together with the press."""
    stayed: bool = False
    told: bool = False
    silent_at: float = math.inf
    """When it has been silent for so long that its release was lost, if it would be told [s]."""
    ended: bool = False
    """Whether its release has been told, or is nobody's as its press was none."""
    live_from: float = math.inf
    """After a pause of the line: how far apart repeats are that are no sooner than before [s]."""
    live: int = 0
    """So many of those came in a row."""


class KeyboardHold:
    """Key presses and repeats in, presses, repeats and releases out; the clock is passed in.

    How fast the keyboard repeats is measured over its last few repeats, whatever the key. The
    longest of these intervals counts, because a slow line delivers repeats in bursts.

    A key that was held when all were let go may still be down, and repeat. Until it has been silent
    for as long as a hold lasts its events say so: what it drove before, it drives no more.
    """

    def __init__(self) -> None:
        self._holds: dict[str, _Hold] = {}
        self._let_go: dict[str, float] = {}
        self._paused: dict[str, tuple[float, float]] = {}
        self._intervals: deque[float] = deque(maxlen=_REPEATS_MEASURED)

    @property
    def held(self) -> tuple[str, ...]:
        """Keys that count as held, in the order they were pressed."""
        return tuple(key for key, hold in self._holds.items() if not hold.stayed)

    @property
    def waiting(self) -> tuple[str, ...]:
        """Keys that are down and drive only when they are pressed anew."""
        return tuple(key for key, hold in self._holds.items() if hold.stayed)

    def press(
        self, key: str, now: float, *, read: float | None = None, old: bool = False
    ) -> tuple[ControlEvent, ...]:
        """The terminal reports a key: releases that were due by now, then its press or repeat.

        Args:
            key: What it is called.
            now: The time [s].
            read: When it was read, if that is not just now [s].
            old: Whether it may have been typed while the console was away; it drives only when it
                is pressed anew.
        """
        key = canonical_key(key)
        read = now if read is None else read
        due = list(self.expire(now))
        hold = self._holds.get(key)
        if hold is None:
            stayed = now < self._let_go.pop(key, now) or old
            hold = _Hold(last=read, deadline=now + _FIRST_HOLD_S, stayed=stayed, ended=old)
            until, live_from = self._paused.pop(key, (read, math.inf))
            hold.live_from = math.inf if stayed or read > until else live_from
            self._holds[key] = hold
            return (*due, ControlEvent(name=key, pressed=True, stayed=stayed, old=old))
        resumes = self._is_live(hold, read)
        self._repeated(hold, read)
        if hold.stayed and resumes:
            hold.stayed = hold.ended = False
            hold.at_once, hold.live_from = 0, math.inf
            hold.deadline = now + self._repeat_hold()
            return (*due, ControlEvent(name=key, pressed=True))
        if hold.at_once >= _OLD_REPEATS and not hold.stayed:
            hold.stayed = hold.ended = True
            due.append(ControlEvent(name=key, pressed=False))
        hold.deadline = now + self._repeat_hold()
        event = ControlEvent(name=key, pressed=True, repeat=True, stayed=hold.stayed, old=old)
        return (*due, event)

    def down(
        self, key: str, now: float, *, repeat: bool, old: bool = False
    ) -> tuple[ControlEvent, ...]:
        """A terminal that will tell of the release reports a key: its press, or a repeat.

        A repeat of a key that does not count as held was pressed before all were let go, before the
        terminal fell silent, or unseen: it is a repeat, never a press, and its release is nobody's.

        Args:
            key: What it is called.
            now: The time [s].
            repeat: Whether it is a repeat.
            old: As of `press`.
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
            self._let_go.pop(key, None)
            hold = self._holds[key] = _Hold(last=now, deadline=now, stayed=repeat or old, told=True)
            hold.ended = hold.stayed
        elif repeat:
            self._repeated(hold, now)
        self.heard(now)
        self._moved(now, hold if repeat else None)
        return (
            *due,
            ControlEvent(name=key, pressed=True, repeat=repeat, stayed=hold.stayed, old=old),
        )

    def up(self, key: str, now: float) -> tuple[ControlEvent, ...]:
        """A key went up."""
        key = canonical_key(key)
        self._moved(now, None)
        self._let_go.pop(key, None)
        return self._ended((key,)) if key in self._holds else ()

    def heard(self, now: float) -> None:
        """The terminal is there: keys whose release it will tell stay held."""
        for hold in self._holds.values():
            if hold.told:
                hold.deadline = max(hold.deadline, now + _FIRST_HOLD_S)

    @property
    def waits_for_releases(self) -> bool:
        """Whether keys are held until the terminal tells, so that it must be heard."""
        return any(hold.told for hold in self._holds.values())

    @property
    def hold_s(self) -> float:
        """How long a repeat holds where no release is told [s]."""
        return self._repeat_hold()

    def expire(self, now: float) -> tuple[ControlEvent, ...]:
        """Releases that are due, the earliest first."""
        ends = ((min(hold.deadline, hold.silent_at), key) for key, hold in self._holds.items())
        due = sorted((end, key) for end, key in ends if end <= now)
        for _, key in due:
            hold = self._holds[key]
            if self._intervals and hold.repeats and not (hold.told or hold.stayed):
                usual = statistics.median(self._intervals)
                self._paused[key] = hold.last + _RESUMES_S, _LIVE_SHARE * usual
        return self._ended(key for _, key in due)

    def release_all(self, now: float) -> tuple[ControlEvent, ...]:
        """Everything is let go: the terminal lost the focus, was suspended, or the console ends."""
        self._let_go |= dict.fromkeys(self._holds, now + _FIRST_HOLD_S)
        self.resume_none()
        return self._ended(tuple(self._holds))

    def resume_none(self) -> None:
        """A robot was stopped or changed hands: nothing that was held drives on after a pause."""
        self._paused.clear()
        for hold in self._holds.values():
            hold.live_from = math.inf

    def _is_live(self, hold: _Hold, read: float) -> bool:
        """Whether a key that was held before a pause of the line is seen to be down now."""
        hold.live = hold.live + 1 if read - hold.last >= hold.live_from else 0
        return hold.live >= _LIVE_REPEATS

    def _lost(self) -> tuple[ControlEvent, ...]:
        """Keys whose releases may be told to somebody else from here on go up now."""
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
            soon = max(_FIRST_HOLD_S, _REPEAT_FACTOR * max(self._intervals))
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
            return _FIRST_HOLD_S
        return min(_FIRST_HOLD_S, max(_LEAST_HOLD_S, _REPEAT_FACTOR * max(self._intervals)))
