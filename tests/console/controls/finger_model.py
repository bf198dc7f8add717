"""Fingers, a keyboard, a line and a console's key rules, on one clock: what moves, and may it?

Times are whole milliseconds here, so that equal situations compare equal.
"""

from __future__ import annotations

import copy
import enum
import math
from typing import Any

from rune_tui.controls.keyboard import KeyboardHold

TICK_MS = 50
_ROUND_TRIP_MS = 20
_REPEAT_MS = 33
_DELAY_MS = 500
_GAP_MS = 300
_QUEUED = 4
_LOOKS_UP_MS = 700
_LOOKS_PRESSED_MS = 150
_LONG_AGO = 2.0


class Terminal(enum.Enum):
    """What the terminal reports.

    Attributes:
        ANSWERS: No releases; it answers questions.
        MUTE: No releases, no answers.
        RELEASES: Releases.
        LOSES_RELEASES: Releases, but none of those that come now.
    """

    ANSWERS = "answers"
    MUTE = "mute"
    RELEASES = "releases"
    LOSES_RELEASES = "loses releases"

    @property
    def timed(self) -> bool:
        return self in {Terminal.ANSWERS, Terminal.MUTE}


class Scene:
    """A console's key rules, and two fingers: on w, which may be held, and on d, which taps.

    Attributes:
        keyboard: The rules.
        now: The time [ms].
        down: Fingers that are down.
        unseen: Fingers that were down at the last stop, and have not been up since.
    """

    ACTIONS = (
        *("press", "repeat", "gap", "burst", "lift", "rest", "tap d"),
        *("stop", "suspend", "lose focus", "hand over"),
    )

    def __init__(self, terminal: Terminal) -> None:
        self.terminal = terminal
        self.keyboard = KeyboardHold()
        self.keyboard.answers = terminal is not Terminal.MUTE
        self.now = 100_000
        self.down: set[str] = set()
        self.unseen: set[str] = set()
        self._due = self.now
        self._repeats = 0
        self._silent = False
        self._came = -math.inf
        self._alone = False

    def may(self, action: str) -> bool:
        """Whether this can happen now."""
        if action == "press":
            return "w" not in self.down
        if action in {"repeat", "burst"}:
            return "w" in self.down and not self._silent
        if action == "lift":
            return "w" in self.down
        return True

    def act(self, action: str) -> None:
        """It happens; afterwards nothing may move that must not."""
        getattr(self, f"_{action.replace(' ', '_')}")()
        self._check(action)

    def _press(self) -> None:
        self.down.add("w")
        self._repeats, self._silent = 0, False
        self._key("w", repeat=False)
        self._pass(20)

    def _repeat(self) -> None:
        self._pass(self._until_repeat())
        self._key("w", repeat=True)

    def _gap(self) -> None:
        self._pass(_GAP_MS)

    def _burst(self) -> None:
        self._pass(_GAP_MS, stalled=True)
        for _ in range(_QUEUED):
            self._key("w", repeat=True)
            self.now += 1

    def _lift(self) -> None:
        self.down.discard("w")
        self.unseen.discard("w")
        if self.terminal is Terminal.RELEASES:
            self.keyboard.up("w", self._s)
        self._pass(100)

    def _rest(self) -> None:
        self._pass(800)

    def _tap_d(self) -> None:
        self._silent = True
        self._key("d", repeat=False)
        if not self.terminal.timed:
            self.keyboard.up("d", self._s)
        self._pass(20)

    def _stop(self) -> None:
        self.keyboard.stop({"w", "d"}, self._s)
        self._stopped()

    def _hand_over(self) -> None:
        self._stop()

    def _lose_focus(self) -> None:
        self.keyboard.release_all(self._s)
        self._stopped()

    def _suspend(self) -> None:
        queued = _QUEUED if "w" in self.down and not self._silent else 0
        self.now += 600
        self._due = self.now
        self._lose_focus()
        for _ in range(queued):
            self._key("w", repeat=True, stale=True)
        self._pass(20)

    def key(self) -> tuple[Any, ...]:
        """Equal for two scenes that go on alike."""
        return (
            frozenset(self.down),
            frozenset(self.unseen),
            self._repeats,
            self._silent,
            self._alone,
            _relative(self._came, self.now),
            self._due - self.now,
            _frozen(self.keyboard, self._s),
        )

    def copied(self) -> Scene:
        """Another one that goes on by itself."""
        made = copy.copy(self)
        made.down, made.unseen = set(self.down), set(self.unseen)
        made.keyboard = _copied(self.keyboard)
        return made

    @property
    def _s(self) -> float:
        return self.now / 1000.0

    def _until_repeat(self) -> int:
        self._repeats = min(self._repeats + 1, 3)
        return _DELAY_MS - 20 if self._repeats == 1 else _REPEAT_MS

    def _stopped(self) -> None:
        # On a terminal without releases, a finger whose repeats another key took cannot be seen.
        self.unseen = set(self.down) - ({"w"} if self._silent and self.terminal.timed else set())

    def _key(self, key: str, *, repeat: bool, stale: bool = False) -> None:
        if key == "w":
            self._alone = repeat and self.now - self._came >= _LOOKS_UP_MS
            self._came = self.now
        if self.terminal.timed:
            self.keyboard.press(key, self._s, stale=stale)
        else:
            self.keyboard.down(key, self._s, repeat=repeat, stale=stale)
        self._check(f"key {key}")

    def _pass(self, milliseconds: int, *, stalled: bool = False) -> None:
        """Time goes by; the console ticks, and the terminal answers."""
        end = self.now + milliseconds
        while self._due <= end:
            self.now = self._due
            self._due += TICK_MS
            if not stalled and self.terminal is not Terminal.MUTE:
                self.keyboard.heard(self._s, (self.now - _ROUND_TRIP_MS) / 1000.0)
            self.keyboard.expire(self._s)
            self._check("a tick")
        self.now = end

    def _check(self, action: str) -> None:
        silent = self.now - self._came
        # Silent, one repeat, silent: a press looks the same. Silent, then another key takes the
        # repeats: so does a key that went up.
        same = self._alone and silent >= _LOOKS_PRESSED_MS
        same = same or (self._silent and silent >= _LOOKS_UP_MS)
        if self.terminal.timed and same:
            self.unseen.discard("w")
        moving = self.keyboard.held and self.unseen
        assert not moving, f"{self.keyboard.held} drive at {action} before {self.unseen} went up"


def _relative(moment: float, now: float) -> float:
    return max(-_LONG_AGO * 1000, moment - now)


def _copied(keyboard: KeyboardHold) -> KeyboardHold:
    """As `copy.deepcopy`, many times faster."""
    made, guard = copy.copy(keyboard), copy.copy(keyboard._guard)
    made._guard = guard
    made._dropped = copy.copy(keyboard._dropped)
    made._dropped._guard = guard
    made._holds = {key: copy.copy(hold) for key, hold in keyboard._holds.items()}
    made._paused = dict(keyboard._paused)
    made._rate = copy.copy(keyboard._rate)
    made._rate.intervals = keyboard._rate.intervals.copy()
    guard._down, guard._reported, guard._timed = (
        set(guard._down),
        set(guard._reported),
        set(guard._timed),
    )
    guard._came, guard._answered = dict(guard._came), guard._answered.copy()
    return made


def _frozen(keyboard: KeyboardHold, now: float) -> tuple[Any, ...]:
    """What the rules know, with moments relative to now; long ago is long ago."""

    def at(moment: float) -> float:
        return round(max(-_LONG_AGO, moment - now), 4)

    guard = keyboard._guard
    return (
        tuple(
            (
                key,
                (at(hold.last), at(hold.deadline), at(hold.silent_at), hold.live_from),
                (min(hold.repeats, 3), min(hold.at_once, 2), hold.at_once == hold.repeats),
                (min(hold.live, 3), hold.fine),
                (hold.must_release, hold.releases_reported, hold.ended),
            )
            for key, hold in keyboard._holds.items()
        ),
        tuple((key, at(until), apart) for key, (until, apart) in keyboard._paused.items()),
        tuple(round(each, 4) for each in keyboard._rate.intervals),
        keyboard._resumable,
        (keyboard._dropped.dropping, at(keyboard._dropped._last)),
        (guard.state.value, guard._candidate, min(guard._repeats, 3), guard._needed),
        (at(guard._last), at(guard._stopped)),
        (frozenset(guard._down), frozenset(guard._reported), frozenset(guard._timed)),
        tuple((key, at(came)) for key, came in guard._came.items()),
        tuple((at(read), at(asked)) for read, asked in list(guard._answered)[-2:]),
    )


def explore(terminal: Terminal, length: int) -> int:
    """Every interleaving up to this length, equal situations once; returns how many there were."""
    fresh: list[tuple[Scene, tuple[str, ...]]] = [(Scene(terminal), ())]
    known = {hash(fresh[0][0].key())}
    for number in range(length):
        found = []
        for scene, way in fresh:
            for action in filter(scene.may, Scene.ACTIONS):
                after = scene.copied()
                try:
                    after.act(action)
                except AssertionError as error:
                    error.add_note(f"{terminal.value}: {', '.join((*way, action))}")
                    raise
                key = hash(after.key())
                if key not in known:
                    known.add(key)
                    if number < length - 1:
                        found.append((after, (*way, action)))
        fresh = found
    return len(known)
