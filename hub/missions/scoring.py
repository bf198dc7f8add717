"""The score of a mission in an arena whose victims are known; pure.

| for | points |
| --- | --- |
| each victim with a mark within `FARTHEST` | 20 |
| the place of that mark | 10 within 0.5 m, then less, 0 at 2 m |
| each mark without a victim | -10 |

The sum counts as often as the arena's weight says, over the square of one more than the operators.
So did the rescue leagues from 2003 on; these points are our own. A mission does not record bumps,
and the quality of its map does not count here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from hub.gcm.mapping import InterestPoint, PointKind
from hub.missions.matching import match
from hub.values import dataclass

FOUND, PLACED, FALSE = 20.0, 10.0, -10.0
EXACT, FARTHEST = 0.5, 2.0
"""A mark counts fully up to the first distance from its victim, and up to the second at all [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Victim:
    """A victim of the arena.

    Attributes:
        name: Its name.
        x: In `map` [m].
        y: The same.
    """

    name: str
    x: float
    y: float


@dataclass(frozen=True, slots=True, kw_only=True)
class VictimScore:
    """How a victim was found.

    Attributes:
        victim: The victim.
        mark: Number of its mark; 0: it was missed.
        error: Distance of the mark [m]; NaN: it was missed.
        points: What it counts, without weight and operators.
    """

    victim: Victim
    mark: int = 0
    error: float = math.nan
    points: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """The score of a mission.

    Attributes:
        findings: One for each victim.
        false: Numbers of the marks without a victim.
        repeated: Numbers of further marks of a victim; they count nothing.
        weight: The arena's weight.
        operators: Number of operators.
    """

    findings: tuple[VictimScore, ...]
    false: tuple[int, ...]
    repeated: tuple[int, ...]
    weight: float
    operators: int

    @property
    def found(self) -> int:
        """Number of victims with a mark."""
        return sum(finding.mark > 0 for finding in self.findings)

    @property
    def total(self) -> float:
        """The score."""
        points = sum(finding.points for finding in self.findings) + FALSE * len(self.false)
        return self.weight * points / (1 + self.operators) ** 2


def score(
    victims: Sequence[Victim], marks: Sequence[InterestPoint], weight: float, operators: int
) -> Score:
    """Compare the marks of victims with the victims, paired as `match` does.

    Args:
        victims: All victims, with their places in `map`.
        marks: All marks; those of landmarks do not count.
        weight: The arena's weight.
        operators: Number of operators.
    """
    marked = [mark for mark in marks if mark.kind is PointKind.VICTIM]
    pairs = match(
        [(mark.x, mark.y) for mark in marked], [(each.x, each.y) for each in victims], FARTHEST
    )
    findings = {
        pair.place: VictimScore(
            victim=victims[pair.place],
            mark=marked[pair.mark].number,
            error=pair.distance,
            points=FOUND + PLACED * min(1.0, (FARTHEST - pair.distance) / (FARTHEST - EXACT)),
        )
        for pair in pairs
    }
    used = {pair.mark for pair in pairs}
    near = {
        number
        for number, mark in enumerate(marked)
        if any(math.hypot(mark.x - each.x, mark.y - each.y) <= FARTHEST for each in victims)
    } - used
    return Score(
        findings=tuple(
            findings.get(place) or VictimScore(victim=victim)
            for place, victim in enumerate(victims)
        ),
        false=tuple(mark.number for number, mark in enumerate(marked) if number not in near | used),
        repeated=tuple(marked[number].number for number in sorted(near)),
        weight=weight,
        operators=operators,
    )
