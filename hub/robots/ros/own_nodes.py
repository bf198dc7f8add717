"""Which nodes of a robot with ROS are the way of Rune's own messages; pure."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

_BRIDGE: Final = re.compile(r"foxglove_(?:bridge|nodelet_manager)")
"""Names of bridges; the launch file of that for ROS 1 loads it into a manager of nodelets."""
_HUB: Final = re.compile(r"(?:^|/)rune_")
"""Names of nodes of Rune's hubs; `rune` alone is a robot of Rune."""


def foreign(nodes: Iterable[str]) -> tuple[str, ...]:
    """The nodes that are not the way of messages of any hub of Rune."""
    return tuple(name for name in nodes if not (_BRIDGE.search(name) or _HUB.search(name)))


def rivals(publishers: Iterable[str]) -> tuple[str, ...]:
    """The nodes that publish besides this hub, other hubs of Rune among them.

    Args:
        publishers: Without the node of this hub, as lines list them.
    """
    return tuple(name for name in publishers if not _BRIDGE.search(name))
