"""Victims that were found: marks of the operator beside true places."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hub.missions.matching import match
from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.estimate import Estimate, unknown
from rune_study.statistics.arrays import Floats

RADIUS_M = 1.0
"""Farthest distance of a mark from its victim [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A mark that the operator set.

    Attributes:
        time: When [s].
        x: In the frame of the true places [m].
        y: The same.
        removed: Whether he took it away again: then it does not count.
    """

    time: float
    x: float
    y: float
    removed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class VictimsFound:
    """How many victims were found.

    Attributes:
        found: Victims with a mark.
        victims: All of them.
        false: Marks without a victim.
        marks: Marks that count.
        error: Mean distance of the marks that found one [m]; NaN: none did.
    """

    found: int
    victims: int
    false: int
    marks: int
    error: float

    @property
    def fraction(self) -> float:
        """Share of victims found; NaN without victims."""
        return self.found / self.victims if self.victims else math.nan

    @property
    def precision(self) -> float:
        """Share of marks that found one; NaN without marks."""
        return self.found / self.marks if self.marks else math.nan


def victims_found(
    marks: Sequence[Mark], places: npt.ArrayLike, radius: float = RADIUS_M
) -> VictimsFound:
    """Pair marks and victims: most pairs within the radius, then least distance.

    Args:
        marks: All marks.
        places: True places of victims [m], shape (victims, 2).
        radius: Farthest distance of a pair [m].
    """
    kept = [each for each in marks if not each.removed]
    true = _places(places)
    pairs = match([(each.x, each.y) for each in kept], true, radius)
    return VictimsFound(
        found=len(pairs),
        victims=len(true),
        false=len(kept) - len(pairs),
        marks=len(kept),
        error=float(np.mean([each.distance for each in pairs])) if pairs else math.nan,
    )


def first_victim(
    marks: Sequence[Mark], places: npt.ArrayLike, until: float, radius: float = RADIUS_M
) -> Estimate:
    """Time from the start of the trial to the first mark near a victim.

    Args:
        marks: All marks; those that were removed do not count.
        places: True places of victims [m], shape (victims, 2).
        until: End of the trial [s]. Without a find the time is censored there.
        radius: Farthest distance of a mark [m].
    """
    true = _places(places)
    if not len(true):
        return unknown("there is no victim")
    near = [
        each.time
        for each in marks
        if not each.removed
        and each.time <= until
        and (np.hypot(true[:, 0] - each.x, true[:, 1] - each.y) <= radius + 1e-9).any()
    ]
    if not near:
        return Estimate(value=until, n=1, censored=True, note="no victim was found")
    return Estimate(value=min(near), n=1)


def _places(places: npt.ArrayLike) -> Floats:
    array = np.asarray(places, np.float64)
    if array.size == 0:
        return np.empty((0, 2))
    if array.ndim != 2 or array.shape[1] != 2 or not np.isfinite(array).all():
        text = f"places of victims need a finite x and y each, but their shape is {array.shape}"
        raise DataError(text)
    return array
