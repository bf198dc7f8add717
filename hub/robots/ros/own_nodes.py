"""Which nodes of a robot with ROS are the way of Rune's own messages; pure."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

_OWN: Final = re.compile(r"foxglove_bridge|(?:^|/)rune_")
"""Names of nodes through which Rune itself publishes; `rune` alone is a robot of Rune."""


def foreign(nodes: Iterable[str]) -> tuple[str, ...]:
    """The nodes that are not the way of Rune's own messages."""
    return tuple(name for name in nodes if not _OWN.search(name))
