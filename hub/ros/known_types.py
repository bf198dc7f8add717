"""Types that every system with ROS 2 has, for recordings that name them and do not define them."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path

_TABLE = Path(__file__).with_suffix(".txt")


def known_text(name: str) -> str | None:
    """The fields of a type such as "std_msgs/msg/Header"; None: it is not known."""
    return known_texts().get(name)


@functools.cache
def known_texts() -> Mapping[str, str]:
    """The fields of all known types, by name."""
    _, *parts = _TABLE.read_text("utf-8").split("MSG: ")
    return {name: text for name, _, text in (part.partition("\n") for part in parts)}
