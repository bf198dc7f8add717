"""Robots of a study that are not simulated."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

from hub.ipc.endpoints import endpoint_of
from hub.values import dataclass
from rune_study.plan.study_spec import ConditionSpec, StudySpec


@dataclass(frozen=True, slots=True, kw_only=True)
class RealRobots:
    """Robots that are not simulated.

    Attributes:
        hubs: Endpoints of their hubs, one for each robot; none: robots are simulated.
        keys: The key file, for hubs on other machines.
    """

    hubs: tuple[str, ...] = ()
    keys: Path | None = None

    def of(self, spec: ConditionSpec) -> RealRobots:
        """The robots of a condition, which may name its own."""
        own = tuple(endpoint_of(hub) for hub in spec.hubs)
        return self if self.hubs else dataclasses.replace(self, hubs=own)


def real_problems(study: StudySpec, hubs: Sequence[str]) -> list[str]:
    """Why these hubs do not fit all conditions of a study, a sentence each; none: all is well."""
    if not hubs:
        return []
    robots = {spec.robots for spec in study.conditions}
    found = []
    if robots != {len(hubs)}:
        those = " and ".join(map(str, sorted(robots)))
        found.append(f"--hub names {len(hubs)} robots, and conditions have {those}")
    return found + sorted({text for spec in study.conditions for _, text in not_for_real(spec)})


def not_for_real(spec: ConditionSpec) -> Iterator[tuple[str, str]]:
    """What a condition sets that a study cannot set on a real robot: keys, and a sentence each."""
    given = {"settings": spec.settings, "speed": spec.speed}
    for name, value in given.items():
        if value:
            text = (
                f"{name!r} is for simulated robots; a real one has its own file, so write the "
                "value there and start its hub again"
            )
            yield name, text
