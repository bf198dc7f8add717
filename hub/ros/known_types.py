"""Types that every system with ROS has, for topics that name their type and do not define it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Final

_TABLE: Final = Path(__file__).with_suffix(".txt")
_TABLE_OF_ROS_1: Final = _TABLE.with_stem(f"{_TABLE.stem}_ros1")


def known_text(name: str, version: int = 2) -> str | None:
    """The fields of a type such as "std_msgs/msg/Header"; None: it is not known.

    Args:
        name: Its name, as ROS 2 writes it.
        version: Of ROS, 1 or 2: some types of both have other fields.
    """
    return next(iter(known_texts(version).get(name, ())), None)


@functools.cache
def known_texts(version: int = 2) -> Mapping[str, tuple[str, ...]]:
    """The fields of all known types of ROS 1 or 2, by name.

    A type whose fields differ between distributions has several texts. Of those of ROS 2 the one
    of Humble is the first, of those of ROS 1 the one of Noetic.
    """
    found: dict[str, tuple[str, ...]] = {}
    _, *parts = _TABLE.read_text("utf-8").split("MSG: ")
    if version == 1:
        _, *others = _TABLE_OF_ROS_1.read_text("utf-8").split("MSG: ")
        replaced = {each.partition("\n")[0] for each in others}
        parts = [each for each in parts if each.partition("\n")[0] not in replaced] + others
    for part in parts:
        name, _, text = part.partition("\n")
        found[name] = (*found.get(name, ()), text)
    return found
