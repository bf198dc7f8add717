"""Keys that count as held down, on terminals that tell when they go up and on those that do not.

Most terminals repeat a held key and say nothing when it goes up. So a key counts as held until its
repeats stay away: after the first press for as long as keyboards wait before they repeat, then
for a few repeat intervals. No keyboard repeats at once: repeats that come together with their press
were held back on the way. Such a key was pressed some time ago, and drives only when it is pressed
anew.

Where the terminal tells of releases a key is held until its own, but only as long as anything is
heard of the terminal: over a line that is cut, no release comes.
"""

from __future__ import annotations

from collections import deque
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
_OLD_REPEATS = 2
"""So many of them right behind the press tell that it is old; two quick taps look like one."""


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
    ended: bool = False
    """Whether its release has been told, or is nobody's as its press was none."""


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
        self._intervals: deque[float] = deque(maxlen=_REPEATS_MEASURED)

    @property
    def held(self) -> tuple[str, ...]:
        """Keys that count as held, in the order they were pressed."""
        return tuple(key for key, hold in self._holds.items() if not hold.stayed)

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
            self._holds[key] = _Hold(
                last=read, deadline=now + _FIRST_HOLD_S, stayed=stayed, ended=old
            )
            return (*due, ControlEvent(name=key, pressed=True, stayed=stayed, old=old))
        self._repeated(hold, read)
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
            due += self.up(key)  # which did not come
            hold = None
        if hold is None:
            self._let_go.pop(key, None)
            hold = self._holds[key] = _Hold(last=now, deadline=now, stayed=repeat or old, told=True)
            hold.ended = hold.stayed
        self.heard(now)
        return (
            *due,
            ControlEvent(name=key, pressed=True, repeat=repeat, stayed=hold.stayed, old=old),
        )

    def up(self, key: str) -> tuple[ControlEvent, ...]:
        """A key went up."""
        key = canonical_key(key)
        self._let_go.pop(key, None)
        hold = self._holds.pop(key, None)
        return () if hold is None or hold.ended else (ControlEvent(name=key, pressed=False),)

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
        due = sorted(
            (hold.deadline, key) for key, hold in self._holds.items() if hold.deadline <= now
        )
        released = []
        for _, key in due:
            hold = self._holds.pop(key)
            if not hold.ended:
                released.append(ControlEvent(name=key, pressed=False))
        return tuple(released)

    def release_all(self, now: float) -> tuple[ControlEvent, ...]:
        """Everything is let go: the terminal lost the focus, was suspended, or the console ends."""
        released = tuple(
            ControlEvent(name=key, pressed=False)
            for key, hold in self._holds.items()
            if not hold.ended
        )
        self._let_go |= dict.fromkeys(self._holds, now + _FIRST_HOLD_S)
        self._holds.clear()
        return released

    def _repeated(self, hold: _Hold, read: float) -> None:
        """Measure how fast the keyboard repeats, and what came all at once."""
        together = read - hold.last < _BURST_S
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
