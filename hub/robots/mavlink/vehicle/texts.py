"""The texts of a vehicle, joined from their parts; pure."""

from __future__ import annotations

from collections import deque
from typing import Final

from hub.gcm.diagnostics import Severity
from hub.plain_text import plain
from hub.values import dataclass

_KEPT: Final = 50
"""Most texts that are kept."""
_MOST_PARTS: Final = 8
"""Most parts of one text; each has 50 letters."""
_PART: Final = 50
_JOINED_S: Final = 1.0
"""A text whose parts do not come within this time ends as it is [s]."""
_REPEATED: Final = ("Field Elevation Set",)
"""Texts that come every second and mean nothing to an operator."""
_SEVERITIES: Final = (Severity.ERROR,) * 4 + (Severity.WARN,) * 2 + (Severity.OK,) * 2
"""By MAV_SEVERITY: emergency, alert, critical, error; warning, notice; info, debug."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleText:
    """One text.

    Attributes:
        time: When it came, on the monotonic clock [s].
        level: How bad it is.
        text: Its words, without control characters.
    """

    time: float
    level: Severity
    text: str


class VehicleTexts:
    """The newest texts of a vehicle."""

    def __init__(self) -> None:
        self._texts: deque[VehicleText] = deque(maxlen=_KEPT)
        self._new: deque[VehicleText] = deque(maxlen=_KEPT)
        self._number = 0
        self._parts: dict[int, str] = {}
        self._level = 0
        self._since = 0.0

    def add(self, severity: int, text: str, number: int, part: int, now: float) -> None:
        """Take a STATUSTEXT.

        Args:
            severity: Its MAV_SEVERITY.
            text: Its words, at most 50 letters.
            number: Equal in all parts of one text; 0: it has one part.
            part: The place of this part, from 0.
            now: Monotonic time [s].
        """
        if number != self._number or not number:
            self.flush(now)
        if part >= _MOST_PARTS:
            return
        if not self._parts:
            self._number, self._level, self._since = number, severity, now
        self._parts[part] = text[:_PART]
        if not number or len(text) < _PART:
            self.flush(now)

    def flush(self, now: float, *, late: bool = False) -> None:
        """End the text whose parts came.

        Args:
            now: Monotonic time [s].
            late: Only if its last part has not come in time.
        """
        if not self._parts or (late and now - self._since < _JOINED_S):
            return
        words = plain("".join(self._parts[place] for place in sorted(self._parts))).strip()
        self._parts.clear()
        self._number = 0
        if not words or words.startswith(_REPEATED):
            return
        level = _SEVERITIES[min(self._level, len(_SEVERITIES) - 1)]
        made = VehicleText(time=now, level=level, text=words)
        self._texts.append(made)
        self._new.append(made)

    def since(self, time: float) -> list[VehicleText]:
        """The texts from a monotonic time [s] on."""
        return [each for each in self._texts if each.time >= time]

    def take(self) -> list[VehicleText]:
        """The texts since the last call."""
        taken = list(self._new)
        self._new.clear()
        return taken
