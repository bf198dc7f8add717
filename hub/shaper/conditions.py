"""The state of a link over time: a pure function of profile, seed and time.

Two runs with one seed meet the same delays, losses and blackouts at the same moments, independent
of what is sent. Each quantity has random numbers of its own, so a change of one key changes
nothing else. They come from BLAKE2b, so they stay the same in other versions of Python.
"""

from __future__ import annotations

import bisect
import hashlib
import math
import statistics
from collections.abc import Callable

from hub.shaper.profile import DirectionSpec, EpisodesSpec, LinkProfile

_SHORTEST_HOLD_S = 0.02
_HOLD_PER_JITTER = 5.0
_KEPT = 100_000
"""Edges that are kept at least: times may go back as far."""
_NORMAL = statistics.NormalDist()


def uniform(seed: int, word: str, index: int) -> float:
    """A random number above 0 and below 1; the same for the same arguments."""
    digest = hashlib.blake2b(f"{seed} {word} {index}".encode(), digest_size=8).digest()
    return ((int.from_bytes(digest, "little") >> 12) + 0.5) * 2.0**-52


class Episodes:
    """Times that alternate with gaps, from random lengths; they begin with a part of a gap."""

    def __init__(
        self, gap: Callable[[int], float], length: Callable[[int], float], first: float
    ) -> None:
        """Draw nothing yet.

        Args:
            gap: Length of the gap before episode n [s].
            length: Length of episode n [s].
            first: The part of the first gap that is left at time 0, 0 to 1.
        """
        self._gap, self._length, self._first = gap, length, first
        self._edges = [0.0]
        """Ends of gaps and of episodes, in turns, from the end of an episode at 0 [s]."""
        self._count = 0

    def at(self, time: float) -> bool:
        """Whether an episode is on at a time [s]."""
        return self._index(time) % 2 == 0

    def next_edge(self, time: float) -> float:
        """The first begin or end of an episode after a time [s]."""
        return self._edges[self._index(time)]

    def _index(self, time: float) -> int:
        while self._edges[-1] <= time:
            gap = self._gap(self._count) * (1.0 if self._count else self._first)
            begin = self._edges[-1] + gap
            self._edges += [begin, begin + self._length(self._count)]
            self._count += 1
            if len(self._edges) > 2 * _KEPT:
                del self._edges[:_KEPT]
        return bisect.bisect_right(self._edges, time)


def spaced(spec: EpisodesSpec | None, seed: int, word: str) -> Episodes | None:
    """Blackouts or bursts, with lengths between the shortest and the longest."""
    if spec is None:
        return None

    def within(span: tuple[float, float], what: str) -> Callable[[int], float]:
        low, high = span
        return lambda n: low + (high - low) * uniform(seed, f"{word} {what}", n)

    first = uniform(seed, f"{word} first", 0)
    return Episodes(within(spec.gap, "gap"), within(spec.length, "length"), first)


def losses(spec: DirectionSpec, seed: int, word: str) -> Episodes | None:
    """Times in which packets are lost: a Gilbert model, one step for each full packet's time."""
    if not spec.loss:
        return None

    def steps(mean: float, what: str) -> Callable[[int], float]:
        # Geometric, at least 1.
        log = math.log1p(-1.0 / mean) if mean > 1.0 else -math.inf
        return lambda n: (
            spec.slot * (1.0 + math.floor(math.log(uniform(seed, f"{word} {what}", n)) / log))
        )

    good = max(1.0, spec.burst * (1.0 - spec.loss) / spec.loss)
    first = uniform(seed, f"{word} first", 0)
    return Episodes(steps(good, "good"), steps(spec.burst, "bad"), first)


class DirectionConditions:
    """The state of one direction over time.

    Attributes:
        spec: What the profile says of it.
    """

    def __init__(self, profile: LinkProfile, seed: int, *, up: bool) -> None:
        self.spec = profile.up if up else profile.down
        self._seed, self._word = seed, "up" if up else "down"
        self._losses = losses(self.spec, seed, f"{self._word} loss")
        self._blackouts = spaced(profile.blackouts, seed, "blackout")
        self._bursts = spaced(profile.bursts, seed, "burst")
        self._burst_rate = profile.bursts.rate if profile.bursts else 0.0
        mean, jitter = self.spec.delay, self.spec.jitter
        self._hold = max(_SHORTEST_HOLD_S, _HOLD_PER_JITTER * jitter)
        """Time for which a delay stays the same [s]."""
        self._sigma = math.sqrt(math.log1p((jitter / mean) ** 2)) if jitter else 0.0
        self._held = (-1, mean)

    def delay(self, time: float) -> float:
        """Of a packet that is sent at a time [s]; its logarithm is normal."""
        if not self._sigma:
            return self.spec.delay
        number = int(time / self._hold)
        if number != self._held[0]:
            z = _NORMAL.inv_cdf(uniform(self._seed, f"{self._word} delay", number))
            delay = self.spec.delay * math.exp(self._sigma * (z - self._sigma / 2.0))
            self._held = (number, delay)
        return self._held[1]

    def lost(self, time: float) -> bool:
        """Whether a packet that is sent at a time is lost."""
        return self.blackout(time) or (self._losses is not None and self._losses.at(time))

    def blackout(self, time: float) -> bool:
        """Whether the link is gone at a time."""
        return self._blackouts is not None and self._blackouts.at(time)

    def sent(self, time: float, size: int) -> float:
        """When the last bit of a packet leaves, if the first leaves at `time` [s].

        Args:
            time: [s]
            size: With its headers [bytes].
        """
        bits = 8.0 * size
        while self._bursts is not None:
            rate = self._burst_rate if self._bursts.at(time) else self.spec.rate
            edge = self._bursts.next_edge(time)
            if time + bits / rate <= edge:
                return time + bits / rate
            bits -= (edge - time) * rate
            time = edge
        return time + bits / self.spec.rate
