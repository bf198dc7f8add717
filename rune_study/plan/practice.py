"""The criterion of practice: clauses over what a robot did lately."""

from __future__ import annotations

import dataclasses
import math
import operator
import re
from collections.abc import Callable, Mapping
from typing import Self

from hub.nearest import did_you_mean
from hub.values import dataclass
from rune_study.errors import StudyError
from rune_study.metrics.registry import METRICS
from rune_study.plan.study_spec import ConditionSpec, StudySpec

QUANTITIES = {
    "distance": "m driven",
    "collisions": "collisions",
    "victims": "victims marked where one is",
    "seconds": "s of practice in all",
}
"""What a criterion can name besides metrics, with its unit."""
_NOT_THEN = ("tlx_", "sus", "sart", "sagat_", "ft_secondary", "secondary_")
"""Begins of metrics that practice does not measure: they need questions."""
_COMPARISONS: Mapping[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
}
_CLAUSE = re.compile(r"([a-z][a-z0-9_]{0,39})\s*(>=|<=|>|<)\s*([0-9]{1,9}(?:\.[0-9]{1,6})?)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause:
    """One comparison."""

    quantity: str
    comparison: str
    limit: float


@dataclass(frozen=True, slots=True)
class Criterion:
    """Clauses that all have to hold."""

    clauses: tuple[Clause, ...]

    @classmethod
    def read(cls, text: str) -> Self:
        """Read `distance >= 5 and collisions <= 1`.

        Raises:
            StudyError: It is none.
        """
        return cls(tuple(_clause(part.strip()) for part in text.split(" and ")))

    @property
    def metrics(self) -> frozenset[str]:
        """The metrics that it names."""
        return frozenset(each.quantity for each in self.clauses) - QUANTITIES.keys()

    def holds(self, values: Mapping[str, float]) -> bool:
        """Whether values, by quantity, fulfil all clauses; a missing one fulfils none."""
        return all(
            _COMPARISONS[each.comparison](values.get(each.quantity, math.nan), each.limit)
            for each in self.clauses
        )


def _clause(text: str) -> Clause:
    found = _CLAUSE.fullmatch(text)
    if found is None:
        reason = f"{text!r:.60} is no comparison such as `distance >= 5`"
        raise StudyError(reason)
    known = [*QUANTITIES, *(name for name in METRICS if not name.startswith(_NOT_THEN))]
    if found[1] not in known:
        hint = did_you_mean(found[1], known) or f"; known are {', '.join(known)}"
        reason = f"{found[1]!r} is not measured during practice{hint}"
        raise StudyError(reason)
    return Clause(quantity=found[1], comparison=found[2], limit=float(found[3]))


def practice_of(study: StudySpec, first: ConditionSpec) -> ConditionSpec:
    """What the practice happens with, given the first trial's condition."""
    spec = study.practice
    if spec is None:
        return first
    layout, arena = spec.layout or first.layout, spec.arena or first.arena
    return dataclasses.replace(first, link="", layout=layout, arena=arena)
