"""Tells typed keys from pasted text by its speed, where the terminal does not mark it; pure.

A finger types one key at a time. Text that is pasted without brackets comes as several different
keys in one read, or within 0.01 s. Some of a terminal's keys count:

| key | counts |
| --- | --- |
| that types text, also Enter and Tab | yes |
| the same as the key before, which came in the last 1.1 s | no: a held key repeats |
| any other, such as arrows and F keys | no |

| number of different keys that come together | they are |
| --- | --- |
| one | typed |
| two, and both act at once | typed: two fingers drive |
| two others, or more | pasted: drop all of them, and all keys until none came for 0.3 s |

Keys that act at once are those that drive or stop. They wait for nothing. Every other key that
types text waits 0.01 s for the next one, so that a paste is dropped from its first character on.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final, Generic, TypeVar

from hub.values import dataclass

TOGETHER_S: Final = 0.01
"""Keys that come closer than this were not typed one by one [s]."""
QUIET_S: Final = 0.3
"""Time without a key that ends a paste [s]."""
_HELD_S: Final = 1.1
"""The last key may be held for this time: keyboards wait up to 1 s before they repeat [s]."""
_FINGERS: Final = 2
"""Most keys that count and are typed together."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke(Generic[T]):
    """A key that the terminal reports by its text.

    Attributes:
        key: Its name.
        text: Whether it types text, or is Enter or Tab.
        at_once: Whether it drives or stops, and so waits for nothing.
        event: What the caller passes on.
    """

    key: str
    text: bool
    at_once: bool
    event: T


@dataclass(frozen=True, slots=True, kw_only=True)
class PastedKeys(Generic[T]):
    """Keys of a paste, to be dropped.

    Attributes:
        strokes: The keys. Some before them may have been passed on, if they act at once.
    """

    strokes: tuple[Stroke[T], ...]


class TypingSpeed(Generic[T]):
    """Follows the tables above; the clock is passed in."""

    def __init__(self) -> None:
        self._held = ""
        """The last key that types text: it may be held, and repeat."""
        self._held_since = -math.inf
        """Time of its last report [s]."""
        self._together: dict[str, bool] = {}
        """Keys that count and came together, and whether each acts at once."""
        self._waiting: list[Stroke[T]] = []
        self._last = -math.inf
        """Time of the last key that counts; within a paste, of any [s]."""
        self._pasting = False

    @property
    def waits(self) -> bool:
        """Whether the next key may belong to the last; call `idle` until it does not."""
        return bool(self._together)

    def take(self, strokes: Iterable[Stroke[T]], now: float) -> Iterator[Stroke[T] | PastedKeys[T]]:
        """Keys of one read; returns those to pass on, in order, and those to drop.

        Args:
            strokes: The keys.
            now: The time of the read [s].
        """
        read = tuple(strokes)
        if not read:
            return
        if self._pasting and now - self._last >= QUIET_S:
            self._pasting = False
        for stroke in read:
            self._count(stroke, now)
        if self._pasting or self._is_paste:
            dropped = (*self._waiting, *read)
            self._waiting.clear()
            self._together.clear()
            self._pasting, self._last = True, now
            yield PastedKeys(strokes=dropped)
            return
        for stroke in read:
            if stroke.key in self._together and not stroke.at_once:
                self._waiting.append(stroke)
            else:
                yield from self._passed()
                yield stroke

    def idle(self, now: float) -> Iterator[Stroke[T]]:
        """Note that no input waits to be read; returns keys that were typed after all."""
        if self._together and now - self._last >= TOGETHER_S:
            self._together.clear()
            yield from self._passed()

    @property
    def _is_paste(self) -> bool:
        several = len(self._together)
        return several > _FINGERS or (several == _FINGERS and not all(self._together.values()))

    def _count(self, stroke: Stroke[T], now: float) -> None:
        if not stroke.text:
            return
        repeats = stroke.key == self._held and now - self._held_since < _HELD_S
        self._held, self._held_since = stroke.key, now
        if not repeats:
            self._together[stroke.key] = stroke.at_once
            self._last = now

    def _passed(self) -> Iterator[Stroke[T]]:
        yield from self._waiting
        self._waiting.clear()
