"""A person at a keyboard, a compositor, a line and a console, all left to chance, on one clock."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

from rune_tui.controls.keyboard import KeyboardHold
from tests.console.controls.finger_model import Terminal

TICK_S = 0.05
_ENDS_S = 6.0
_DEAF_S = 0.2
_LOOKS_UP_S = 0.7


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """What is between a finger and the console.

    Attributes:
        terminal: What it reports.
        delay: From a press to its first repeat [s].
        interval: From one repeat to the next [s].
        unsteady: By which share of it repeats come early or late.
        jitter: How long the line holds things back, at most [s].
        batch: The line delivers every so often [s]; 0: at once.
        stalls: When the line carries nothing: begin and end [s].
        grabs: When somebody else gets the keys: begin and end [s].
        reported: Whether the loss of the focus is reported then.
    """

    terminal: Terminal
    delay: float
    interval: float
    unsteady: float
    jitter: float
    batch: float
    stalls: tuple[tuple[float, float], ...]
    grabs: tuple[tuple[float, float], ...]
    reported: bool

    @classmethod
    def by(cls, chance: random.Random) -> Surroundings:
        """As chance has it."""
        disturbed: list[list[tuple[float, float]]] = [[], []]
        at = chance.uniform(0.0, 2.0)
        for _ in range(chance.choice((0, 1, 1, 2))):
            end = at + chance.uniform(0.1, 2.0)
            chance.choice(disturbed).append((at, end))
            at = end + chance.uniform(1.0, 2.0)
        terminal = chance.choice(list(Terminal))
        jitter = chance.choice((0.0, chance.uniform(0.0, 0.05), chance.uniform(0.0, 0.3)))
        return cls(
            terminal=terminal,
            # Silence on a line that cannot be asked must not be taken for a keyboard's delay.
            delay=chance.uniform(0.2, 0.8 if terminal is Terminal.MUTE else 1.0),
            interval=1.0 / chance.uniform(8.0, 50.0),
            unsteady=chance.uniform(0.0, 0.1),
            jitter=jitter,
            batch=chance.choice((0.0, chance.uniform(0.0, 0.3 - jitter))),
            stalls=tuple(disturbed[0]),
            grabs=tuple(disturbed[1]),
            reported=chance.random() < 0.5,
        )


@dataclass
class _Finger:
    """A key, and when it is down."""

    key: str
    times: list[tuple[float, float]] = field(default_factory=list)

    def down(self, now: float) -> bool:
        return any(start <= now < end for start, end in self.times)

    def began(self, now: float) -> float:
        """When it went down, while it is down."""
        return next(start for start, end in self.times if start <= now < end)

    def up_between(self, since: float, now: float) -> bool:
        """Whether it was up at some time in between."""
        if not self.down(since):
            return True
        return next(end for start, end in self.times if start <= since < end) <= now


class Play:
    """Somebody holds keys, a robot is stopped, and keys go up and down.

    Attributes:
        around: What is between finger and console.
        keyboard: The console's rules.
        driven: How many looks found a key that drives after the last stop.
    """

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance
        self.around = Surroundings.by(chance)
        self._fingers = {"w": _Finger("w"), "d": _Finger("d")}
        self._moves()
        self._kind = chance.choice(("stop", "focus lost", "suspended"))
        times = 1 if self._kind == "suspended" else chance.choice((1, 1, 2))
        stops = sorted(chance.uniform(0.0, 3.0) for _ in range(times))
        self._stops = [(at, at + chance.uniform(0.35, 1.5)) for at in stops]
        self.keyboard = KeyboardHold()
        self.keyboard.answers = self.around.terminal is not Terminal.MUTE
        self._unseen: dict[str, float] = {}
        self._came = dict.fromkeys("wd", -math.inf)
        self._sent: dict[str, list[float]] = {"w": [], "d": []}
        """When keys that nobody else got were sent."""
        self._deaf_until = -math.inf
        self.driven = 0

    def run(self) -> None:
        """From the beginning to the end; what moves and must not fails."""
        ticks = [number * TICK_S for number in range(int(_ENDS_S / TICK_S))]
        happens = [(at, "tick", "") for at in ticks]
        happens += [(at, "stop", "") for at, _ in self._stops]
        happens += self._line(ticks)
        if self._kind == "suspended":
            # The console sees at its end what came while it was stopped; it does not tick then.
            happens = [
                (self._awake(at), kind, what)
                for at, kind, what in happens
                if kind != "tick" or self._awake(at) == at
            ]
        for now, kind, what in sorted(happens, key=lambda each: (each[0], each[1] != "stop")):
            self._happen(now, kind, what)
            self._check(now)

    def _moves(self) -> None:
        """When fingers go down and up."""
        chance = self._chance
        for finger in self._fingers.values():
            at = chance.choice((0.0, chance.uniform(0.0, 4.0)))
            while at < _ENDS_S:
                lasts = chance.choice((0.05, chance.uniform(0.1, 1.0), 3.0))
                if finger.key == "w" or chance.random() < 0.5:
                    finger.times.append((at, at + lasts))
                at += lasts + chance.choice((0.05, chance.uniform(0.1, 2.0)))

    def _typed(self) -> list[tuple[float, str, str]]:
        """What the keyboard sends: presses, repeats of the key pressed last, releases."""
        around, moves = self.around, []
        presses = sorted(
            (start, each.key) for each in self._fingers.values() for start, _ in each.times
        )
        for finger in self._fingers.values():
            for start, end in finger.times:
                moves.append((start, "press", finger.key))
                others = (at for at, key in presses if at > start and key != finger.key)
                until = min(end, next(others, math.inf), _ENDS_S)
                at = start + around.delay
                while at < until:
                    moves.append((at, "repeat", finger.key))
                    unsteady = around.unsteady * self._chance.uniform(-1.0, 1.0)
                    at += around.interval * (1.0 + unsteady)
                moves.append((end, "release", finger.key))
        return moves

    def _line(self, ticks: list[float]) -> list[tuple[float, str, str]]:
        """What comes over the line and when; it keeps the order."""
        around = self.around
        grabbed = [
            (at, kind, key)
            for at, kind, key in self._typed()
            if not any(begin <= at < end for begin, end in around.grabs)
        ]
        for at, _, key in grabbed:
            self._sent[key].append(at)
        if around.terminal is Terminal.LOSES_RELEASES:
            grabbed = [each for each in grabbed if each[1] != "release"]
        elif around.terminal.timed:
            grabbed = [(at, "key", key) for at, kind, key in grabbed if kind != "release"]
        if around.reported:
            grabbed += [(begin, "blur", "") for begin, _ in around.grabs]
        if around.terminal is not Terminal.MUTE:
            grabbed += [(tick + 0.005, "answer", str(tick)) for tick in ticks]
        came, last = [], 0.0
        for at, kind, what in sorted(grabbed):
            late = at + 0.005 + self._chance.uniform(0.0, around.jitter)
            if around.batch:
                late = math.ceil(late / around.batch) * around.batch
            for begin, end in around.stalls:
                late = end if begin <= late < end else late
            last = max(last, late)
            came.append((last, kind, what))
        return came

    def _awake(self, at: float) -> float:
        return next((end for begin, end in self._stops if begin <= at < end), at)

    def _happen(self, now: float, kind: str, what: str) -> None:
        keyboard, stale = self.keyboard, now < self._deaf_until
        match kind:
            case "tick":
                keyboard.expire(now)
            case "answer":
                keyboard.heard(now, float(what))
            case "key":
                keyboard.press(what, now, stale=stale)
            case "press" | "repeat":
                keyboard.down(what, now, repeat=kind == "repeat", stale=stale)
            case "release":
                keyboard.up(what, now)
        if kind in {"stop", "blur"}:
            self._stop(now, kind)
        elif what in self._came:
            self._came[what] = now

    def _stop(self, now: float, kind: str) -> None:
        if kind == "stop" and self._kind == "stop":
            self.keyboard.stop("wd", now)
        else:
            self.keyboard.release_all(now)
        if kind == "stop" and self._kind == "suspended":
            self._deaf_until = now + _DEAF_S
        self._unseen = {
            key: now
            for key, each in self._fingers.items()
            if each.down(now) and self._to_be_seen(key, each.began(now), now)
        }

    def _to_be_seen(self, key: str, began: float, now: float) -> bool:
        """Whether anything of a press reached the console, or will in time to be known for old."""
        if self.around.terminal is Terminal.MUTE:
            return self._came[key] > began  # what is on the line looks as if it was pressed later
        return any(began <= at <= now for at in self._sent[key])

    def _check(self, now: float) -> None:
        """Nothing moves before each finger that was down at the stop was up."""
        for key, since in list(self._unseen.items()):
            pressed = [start for start, _ in self._fingers["wd".replace(key, "")].times]
            taken = any(self._fingers[key].began(since) < start <= now for start in pressed)
            # Without releases, a finger whose repeats another key took looks as if it was up.
            hidden = self.around.terminal.timed and taken and now - self._came[key] >= _LOOKS_UP_S
            if hidden or self._fingers[key].up_between(since, now):
                del self._unseen[key]
        if self.keyboard.held:
            self.driven += 1
            assert not self._unseen, (now, self.keyboard.held, self._unseen, self.around)
