"""Which keys count as held down, with and without reported releases; pure.

A key drives while it is HELD. `release_guard` decides whether a press drives: after a stop, no key
drives until all keys that may be down were seen up. Where releases are not reported, `press_runs`
has the keys that drive nothing. The states of one key:

| state | event | terminal reports releases | terminal does not |
| --- | --- | --- | --- |
| UP | press, the guard allows it | HELD | HELD for 0.6 s |
| UP | press, the guard refuses it | MUST BE RELEASED | MUST BE RELEASED, until proven |
| UP | repeat | MUST BE RELEASED | same as a press |
| HELD | repeat | HELD | HELD for 2.5 repeat intervals, 0.15 to 0.6 s |
| HELD | release | UP | not reported |
| HELD | no repeat for that time | see below | UP |
| HELD | two repeats at once with their press | HELD | MUST BE RELEASED: the press is late |
| HELD | a stop of its robot | MUST BE RELEASED | MUST BE RELEASED |
| HELD | focus lost, console suspended | UP, and it must be released | the same |
| MUST BE RELEASED | release | UP | not reported |
| MUST BE RELEASED | press | HELD, if the guard allows it | same as a repeat |
| MUST BE RELEASED | repeat | MUST BE RELEASED | the same; HELD after 3 live repeats |
| any | Super or Cmd goes down | UP | not reported |

A window manager or another window can take a release. So silence ends a hold too where releases are
reported:

| key | HELD ends after |
| --- | --- |
| any | 0.6 s without any report of the terminal |
| the key that repeated last | 0.6 s without a repeat |
| any other key | 5 s without an event of any key |

A keyboard waits before its first repeat. So repeats that come together with their press were
delayed on the line, and the finger may be up. Live repeats have the usual interval. Three of them
show that the finger is down now, if the line paused for at most 1 s and no stop came since.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable

from hub.values import dataclass
from rune_tui.controls.dropped_keys import DroppedKeys
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.press_runs import PressRuns
from rune_tui.controls.release_guard import GuardAction, GuardState, ReleaseGuard
from rune_tui.controls.repeat_rate import FIRST_HOLD_S, RepeatRate
from rune_tui.layout.names import canonical_key

_BURST_S = 0.01
"""Repeats closer than this came together over a slow line and do not measure the rate [s]."""
_SILENT_S = 5.0
"""Longest hold without an event of any key, where releases are reported [s]."""
_GRABS = "super"
"""Part of the names of keys after which a window manager, or macOS with Cmd, takes the keys."""
_LATE_REPEATS = 2
"""Number of repeats right after a press that show a late press; one may be a second quick tap."""
_RESUMES_S = 1.0
"""Longest pause of the line after which a key that is still down drives again [s]."""
_LIVE_REPEATS = 3
"""Number of live repeats in a row that show that a finger is on the key now."""
_REFUSED = 6
"""Number of reports, one by one, after which the operator learns that a late key does not drive."""
_LIVE_SHARE = 0.6
"""Least distance of a live repeat from the one before, as a share of the repeat interval."""


def name_of_key(key: str, character: str | None) -> str:
    """The name of a key in layouts.

    Args:
        key: Its name in the terminal library, such as "plus", "up" or "W".
        character: Its printable character, if any.
    """
    chord = not {"shift"}.issuperset(key.split("+")[:-1])
    if chord or character is None or len(character) != 1 or not character.isprintable():
        return canonical_key(key)
    return canonical_key(character)


def without_shift(key: str, character: str | None) -> str:
    """The name of a key without Shift; empty if Shift is not down.

    Args:
        key: See `name_of_key`.
        character: See `name_of_key`.
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
    releases_reported: bool = False
    """Whether the terminal reports its release."""
    silent_at: float = math.inf
    """From this time on its release counts as lost, if releases are reported [s]."""
    ended: bool = False
    """Whether its release is not passed on: it was passed on already, or its press was not."""
    live_from: float = math.inf
    """After a pause of the line: least interval of live repeats [s]."""
    live: int = 0
    """Number of live repeats in a row."""
    refused: int = 0
    """Number of reports one by one since it was late."""

    def is_live(self, read: float) -> bool:
        """Whether live repeats show that a key from before a pause of the line is down now."""
        self.refused += read - self.last >= _BURST_S
        self.live = self.live + 1 if read - self.last >= self.live_from else 0
        return self.live >= _LIVE_REPEATS

    def reported(self, key: str, *, repeat: bool, fine: bool, stale: bool) -> ControlEvent:
        """A press or repeat of a key as it was reported."""
        return ControlEvent(
            name=key,
            pressed=True,
            repeat=repeat,
            fine=fine,
            timed=not self.releases_reported,
            must_release_first=self.must_release,
            stale=stale,
        )

    def proven_press(self, key: str) -> ControlEvent:
        """The press of a key that is shown to be down."""
        return ControlEvent(name=key, pressed=True, fine=self.fine, timed=True, proven=True)


class KeyboardHold:
    """Turns reports of the terminal into presses, repeats and releases; the clock is passed in.

    Attributes:
        drives: Whether a key drives a robot; the guard gets only those keys.
    """

    def __init__(self, drives: Callable[[str], bool] = lambda _: True) -> None:
        """Start without keys; `drives` says whether a key drives a robot."""
        self.drives = drives
        self._guard = ReleaseGuard()
        self._dropped = DroppedKeys(self._guard)
        self._others = PressRuns(self._guard)
        """Keys that do not drive, where releases are not reported."""
        self._holds: dict[str, _Hold] = {}
        self._paused: dict[str, tuple[float, float]] = {}
        self._resumable = False
        self._rate = RepeatRate()

    @property
    def held(self) -> tuple[str, ...]:
        """Keys that are HELD, in the order of their presses."""
        driving = (key for key, hold in self._holds.items() if not hold.must_release)
        return (*driving, *self._others.keys)

    @property
    def must_release(self) -> tuple[str, ...]:
        """Keys that must be released before a key drives.

        A late key is none of them while live repeats may let it drive on. If it is up already,
        nothing comes of it, and the wait ends without the operator.
        """
        if not self._resumable:
            return self._guard.waited_for
        holds = self._holds
        return tuple(
            key
            for key in self._guard.waited_for
            if key not in holds or holds[key].refused > _REFUSED
        )

    @property
    def tap_first(self) -> bool:
        """Whether only a tap proves a key, because held keys repeat too soon."""
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
        """Take a key from a terminal that reports no releases.

        Args:
            key: Its name.
            now: The time [s].
            read: The time at which it was read, if that is not `now` [s].
            fine: Whether Shift is down.
            stale: Whether it may have been typed while the console paused; then it must be
                released and pressed again to drive. The same holds for a dropped key.

        Returns:
            The releases that are due, then its press or repeat.
        """
        key = canonical_key(key)
        read = now if read is None else read
        stale = self._dropped.drops(read, stale=stale)
        due = [*self._due(now), *self._proven(read)]
        if not self.drives(key):
            return (*due, self._others.report(key, read, fine=fine, stale=stale))
        hold = self._holds.get(key)
        if stale:
            self._guard.saw(key, read)
            self.stop({key}, now)
        if hold is None:
            return (*due, self._first(key, read, now, fine=fine, stale=stale))
        live = hold.is_live(read)
        self._repeated(hold, read)
        hold.deadline = now + self._rate.hold_s
        if hold.must_release and live and self._resumable:
            self._guard.resume()
            hold.must_release = hold.ended = False
            hold.at_once, hold.live_from = 0, math.inf
            hold.fine = fine
            return (*due, hold.proven_press(key))
        if hold.must_release:
            self._guard.key(key, read)
        else:
            self._guard.saw(key, read)
        if hold.at_once >= _LATE_REPEATS and not hold.must_release:
            due += self._end_late(key, hold, now)
        return (*due, hold.reported(key, repeat=True, fine=fine, stale=stale))

    def down(
        self, key: str, now: float, *, repeat: bool, fine: bool = False, stale: bool = False
    ) -> tuple[ControlEvent, ...]:
        """Take a press or a repeat from a terminal that reports releases.

        A repeat of a key that is UP never counts as a press: the press came before the focus was
        lost or the terminal fell silent, or it was not seen. Its release is not passed on.

        Args:
            key: Its name.
            now: The time [s].
            repeat: Whether it is a repeat.
            fine: See `press`.
            stale: See `press`.
        """
        key = canonical_key(key)
        stale = self._dropped.drops(now, stale=stale)
        due = list(self.expire(now))
        hold = self._holds.get(key)
        if hold is not None and not repeat:
            due += self.up(key, now)  # its release was lost
            hold = None
        if _GRABS in key and not repeat:
            due += self._release_reported()
        if hold is None:
            hold = self._holds[key] = _Hold(
                last=now, deadline=now, must_release=repeat, releases_reported=True
            )
        elif repeat:
            self._repeated(hold, now)
        self._guarded(key, hold, now, repeat=repeat)
        if stale and self.drives(key):
            self.stop({key}, now)
        hold.must_release = hold.must_release or stale
        hold.ended = hold.ended or stale or (repeat and hold.must_release)
        self.heard(now)
        self._note_event(now, hold if repeat else None)
        return (*due, hold.reported(key, repeat=repeat, fine=fine, stale=stale))

    def up(self, key: str, now: float) -> tuple[ControlEvent, ...]:
        """Take a release."""
        key = canonical_key(key)
        self._note_event(now, None)
        self._guard.release(key)
        return self._ended((key,)) if key in self._holds else ()

    def heard(self, now: float, asked: float | None = None) -> None:
        """Note that the terminal is alive, so that keys whose release it reports stay HELD.

        Args:
            now: The time at which its report was read [s].
            asked: The time at which the question was written, if the report is an answer [s].
        """
        if asked is not None:
            self._guard.heard(now, asked)
        for hold in self._holds.values():
            if hold.releases_reported:
                hold.deadline = max(hold.deadline, now + FIRST_HOLD_S)

    @property
    def needs_answers(self) -> bool:
        """Whether a key is HELD, or waited for, until the terminal answers."""
        reported = any(hold.releases_reported for hold in self._holds.values())
        waits = self._guard.needs_answers or self._dropped.dropping
        return reported or waits or bool(self._others.keys)

    @property
    def hurries(self) -> bool:
        """Whether a key waits for the next answer of the terminal to drive, or to count."""
        return self._guard.hurries or self._others.awaits_proof

    @property
    def hold_s(self) -> float:
        """Duration of a hold after a repeat, where releases are not reported [s]."""
        return self._rate.hold_s

    @property
    def answers(self) -> bool:
        """Whether the terminal itself answers questions, in order with its keys."""
        return self._guard.answers

    @answers.setter
    def answers(self, itself: bool) -> None:
        self._guard.answers = itself

    def expire(self, now: float) -> tuple[ControlEvent, ...]:
        """Releases that are due, the earliest first; then the press that is proven now, if any."""
        self._dropped.update(now)
        return (*self._due(now), *self._others.expire(now), *self._proven(now))

    def _due(self, now: float) -> tuple[ControlEvent, ...]:
        ends = ((min(hold.deadline, hold.silent_at), key) for key, hold in self._holds.items())
        due = sorted((end, key) for end, key in ends if end <= now)
        for _, key in due:
            hold = self._holds[key]
            reported = hold.releases_reported
            if self._rate and hold.repeats and not (reported or hold.must_release):
                self._paused[key] = hold.last + _RESUMES_S, _LIVE_SHARE * self._rate.usual
        return self._ended(key for _, key in due)

    def _proven(self, now: float) -> tuple[ControlEvent, ...]:
        key = self._guard.update(now)
        hold = self._holds.get(key)
        if hold is None:
            return ()
        hold.must_release = False
        hold.deadline = now + FIRST_HOLD_S  # same as a press now
        return (hold.proven_press(key),)

    def release_all(self, now: float) -> tuple[ControlEvent, ...]:
        """Release all keys: the terminal lost the focus, the console was suspended, or it ends."""
        self.stop(None, now)
        return (*self._ended(tuple(self._holds)), *self._others.release_all())

    def drop(self, now: float) -> None:
        """A key was dropped: drop all keys until they have been quiet; see `dropped_keys`."""
        self._dropped.drop(now)

    def stop(self, keys: Collection[str] | None, now: float) -> None:
        """A robot was stopped or its owner changed: its keys that are down must be released.

        Args:
            keys: The keys that drive it; None: all.
            now: The time [s].
        """
        self._resumable = False
        self._paused.clear()
        for key, hold in self._holds.items():
            hold.live_from = math.inf
            if keys is None or key in keys:
                hold.must_release = hold.must_release or self.drives(key)
        self._guard.stop(None if keys is None else set(keys), now)

    def _first(self, key: str, read: float, now: float, *, fine: bool, stale: bool) -> ControlEvent:
        """The press of a key that was UP, on a terminal that reports no releases."""
        hold = _Hold(last=read, deadline=now + FIRST_HOLD_S, ended=stale, fine=fine)
        hold.must_release = self._guard.key(key, read) is not GuardAction.DRIVE
        until, live_from = self._paused.pop(key, (read, math.inf))
        hold.live_from = math.inf if hold.must_release or read > until else live_from
        self._holds[key] = hold
        return hold.reported(key, repeat=False, fine=fine, stale=stale)

    def _end_late(self, key: str, hold: _Hold, now: float) -> tuple[ControlEvent, ...]:
        """End the hold of a late press."""
        free = self._guard.state is GuardState.FREE
        self._guard.stop({key}, now)
        self._resumable = free or self._resumable
        hold.must_release = hold.ended = True
        hold.refused = 0
        return (ControlEvent(name=key, pressed=False),)

    def _guarded(self, key: str, hold: _Hold, now: float, *, repeat: bool) -> None:
        """Ask the guard about a key whose release is reported."""
        if not self.drives(key):
            return
        if repeat:
            self._guard.repeat(key, now, drives=not hold.must_release)
        else:
            hold.must_release = self._guard.press(key, now) is not GuardAction.DRIVE

    def _release_reported(self) -> tuple[ControlEvent, ...]:
        """Release all keys whose releases may go to another window from now on."""
        return self._ended([key for key, hold in self._holds.items() if hold.releases_reported])

    def _ended(self, keys: Iterable[str]) -> tuple[ControlEvent, ...]:
        ends = [(key, self._holds.pop(key)) for key in keys]
        return tuple(ControlEvent(name=key, pressed=False) for key, hold in ends if not hold.ended)

    def _note_event(self, now: float, repeats: _Hold | None) -> None:
        """Note an event of a key, which postpones the end by silence of all holds.

        Args:
            now: The time [s].
            repeats: The key that repeats, if the event is a repeat: it must go on to repeat.
        """
        for hold in self._holds.values():
            if hold.releases_reported:
                hold.silent_at = now + _SILENT_S
        if repeats is not None and self._rate:
            repeats.silent_at = now + min(_SILENT_S, self._rate.silence_s)

    def _repeated(self, hold: _Hold, read: float) -> None:
        """Measure the repeat interval, and count repeats that came together with the press."""
        # After a pause of the line, repeats faster than the keyboard's were delayed.
        together = read - hold.last < (hold.live_from if hold.live_from < math.inf else _BURST_S)
        if together and hold.at_once == hold.repeats:
            hold.at_once += 1
        # The time from press to first repeat is the keyboard's delay, not its interval.
        if hold.repeats and not together:
            self._rate.add(read - hold.last)
        hold.repeats += 1
        hold.last = read
