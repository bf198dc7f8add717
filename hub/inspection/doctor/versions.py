"""Whether installed libraries are of the versions that pyproject asks for (pure)."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass

_REQUIREMENT = re.compile(
    r"(?P<name>[A-Za-z0-9][A-Za-z0-9._-]*)\s*(\[[^]]*\])?\s*\(?(?P<ranges>[^;)]*)\)?"
    r"\s*(;\s*(?P<marker>.*))?"
)
_RANGE = re.compile(r"(<=|>=|==|!=|<|>)\s*([0-9.]+)")
_EXTRA = re.compile(r"extra\s*==\s*['\"]([^'\"]+)['\"]")
_RELEASE = re.compile(r"\d+(\.\d+)*")

_Numbers = tuple[int, ...]
_COMPARE: dict[str, Callable[[_Numbers, _Numbers], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
_LONGEST = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Requirement:
    """A library that is wanted.

    Attributes:
        name: Its name as a distribution.
        ranges: Such as ">=2.0,<3"; empty if any version will do.
        extra: The extra that wants it; empty if it is always wanted.
    """

    name: str
    ranges: str
    extra: str


def parse_requirement(text: str) -> Requirement | None:
    """A line of Requires-Dist, in the part of PEP 508 that our pyproject uses.

    Returns:
        None for what it does not use, such as requirements of other systems.
    """
    found = _REQUIREMENT.fullmatch(text.strip())
    if found is None:
        return None
    marker = (found["marker"] or "").strip()
    extra = _EXTRA.fullmatch(marker)
    if marker and extra is None:
        return None
    ranges = found["ranges"].replace(" ", "")
    return Requirement(name=found["name"], ranges=ranges, extra=extra[1] if extra else "")


def fits(version: str, ranges: str) -> bool:
    """Whether a version lies in all the ranges; only releases are compared, not "rc1" and so on."""
    release = _numbers(version)
    return all(_COMPARE[found[1]](release, _numbers(found[2])) for found in _RANGE.finditer(ranges))


def _numbers(version: str) -> _Numbers:
    """Its release as numbers, filled up with zeros: 3 and 3.0 are the same."""
    found = _RELEASE.match(version)
    numbers = [int(part[:9]) for part in found[0].split(".")] if found else []
    return tuple([*numbers, *[0] * _LONGEST][:_LONGEST])
