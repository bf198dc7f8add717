"""What the nodes of a robot say is wrong with it, for as long as they repeat it; pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Final

from hub.gcm.diagnostics import DiagnosticStatus
from hub.plain_text import plain
from hub.ros import messages
from hub.ros.values import RosValue

MOST: Final = 32
"""Most problems that are kept; the oldest give way."""
KEPT_S: Final = 10.0
"""How long a problem counts without being repeated [s]."""
_MOST_READ: Final = 1000


class RosDiagnosis:
    """The problems that come as diagnostic_msgs/DiagnosticArray."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[DiagnosticStatus, float]] = {}

    def take(self, value: RosValue, now: float) -> None:
        """Take a message: what is well in it is no problem any more [s, monotonic]."""
        for each in value.get("status")[:_MOST_READ]:
            self._known.pop(_shown(str(each.get("name"))), None)
        for status in messages.diagnostics(value).status[-MOST:]:
            name, text = _shown(status.name), _shown(status.message, 900)
            self._known.pop(name, None)
            said = dataclasses.replace(
                status,
                name=name,
                message=f"{name}: {text or 'it gives no reason'}",
                hardware_id=_shown(status.hardware_id),
            )
            self._known[name] = said, now
        while len(self._known) > MOST:
            del self._known[next(iter(self._known))]

    def problems(self, now: float) -> Iterator[DiagnosticStatus]:
        """Those of the last seconds."""
        for status, at in self._known.values():
            if now - at <= KEPT_S:
                yield status


def _shown(text: str, longest: int = 64) -> str:
    return plain(text)[:longest]
