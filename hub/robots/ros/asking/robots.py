"""Which robots one network of ROS has, by the namespaces of their topics; pure.

A robot has a topic of velocities and an odometry, or frames, below its namespace. Controllers have
such topics of their own below that: they are parts of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from hub.robots.ros.asking.findings import RosFindings
from hub.robots.ros.asking.parts import (
    COMPRESSED,
    IMAGE,
    LASER,
    ODOMETRY,
    TRANSFORMS,
    command_topics,
)

_SEES: Final = (IMAGE, COMPRESSED, LASER, TRANSFORMS)
"""What a robot has, and a controller of a base has not."""


def namespaces_of(found: RosFindings) -> tuple[str, ...]:
    """The namespaces of the robots, sorted; empty: of the robot without one."""
    places = [each.name for each in found.published(ODOMETRY)]
    places += [each.name for each in found.published(TRANSFORMS) if each.name.endswith("/tf")]
    sensors = [each.name for each in found.published(*_SEES)]
    commands = [each.name for topics in command_topics(found) for each in topics]
    found_homes = (_home(name, places) for name in commands if name.endswith("cmd_vel"))
    homes = {home for home in found_homes if home is not None}
    return tuple(sorted(_robots(homes, places, sensors)))


def _home(command: str, places: list[str]) -> str | None:
    """The longest namespace with this topic of velocities and a place; None: there is none."""
    home = command
    while home:
        home = home.rpartition("/")[0]
        if any(_below(name, home) for name in places):
            return home
    return None


def _robots(homes: set[str], places: list[str], sensors: list[str]) -> set[str]:
    """The homes that are robots, and no parts of one."""
    found: set[str] = set()
    for outer in (each for each in homes if not any(_within(each, other) for other in homes)):
        inner = {each for each in homes if _within(each, outer)}
        whole = _robots(inner, places, sensors)
        own = any(_below(name, outer) and not _in_any(name, inner) for name in places)
        if own and not outer:  # beside a robot without a namespace may be others with one
            found |= {each for each in whole if any(_below(name, each) for name in sensors)}
        if own or len(whole) < 2:
            found.add(outer)
        else:
            found |= whole
    return found


def _below(name: str, home: str) -> bool:
    return name.startswith(f"{home}/")


def _within(inner: str, outer: str) -> bool:
    return inner != outer and _below(inner, outer)


def _in_any(name: str, homes: Iterable[str]) -> bool:
    return any(_below(name, home) for home in homes)
