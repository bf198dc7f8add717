"""The texts of a vehicle, joined from their parts; pure.

| event | action |
| --- | --- |
| a text without a number | it is whole |
| a part with a number | keep it; the text ends when no part is missing and the last is short |
| 1 s after its first part | the text ends; "..." stands for each missing part |
| a fifth text begins before the others ended | the oldest ends |
| more than 20 texts in a second, or the same one again within a second | leave it out |
"""

from __future__ import annotations

from collections import deque
from typing import Final

from hub.bucket import Bucket
from hub.gcm.diagnostics import Severity
from hub.plain_text import plain
from hub.values import dataclass

_KEPT: Final = 50
"""Most texts that are kept."""
_MOST_PARTS: Final = 8
"""Most parts of one text; each has 50 letters."""
_PART: Final = 50
_LONGEST: Final = _MOST_PARTS * _PART
_MOST_OPEN: Final = 4
"""Most texts whose parts are waited for."""
_JOINED_S: Final = 1.0
_EACH_S: Final = 1.0
"""Time after which the same text counts again [s]."""
_MOST_PER_S: Final = 20.0
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


@dataclass(slots=True, kw_only=True, eq=False)
class OpenText:
    """A text whose parts come.

    Attributes:
        severity: Its MAV_SEVERITY.
        since: When its first part came, on the monotonic clock [s].
        parts: The parts by their places.
    """

    severity: int
    since: float
    parts: dict[int, str]

    @property
    def whole(self) -> bool:
        """Whether no part is missing."""
        last = max(self.parts)
        return len(self.parts) == last + 1 and (
            len(self.parts[last]) < _PART or last == _MOST_PARTS - 1
        )


class VehicleTexts:
    """The newest texts of a vehicle.

    Attributes:
        left_out: Texts that came too often.
    """

    def __init__(self) -> None:
        self._texts: deque[VehicleText] = deque(maxlen=_KEPT)
        self._new: deque[VehicleText] = deque(maxlen=_KEPT)
        self._open: dict[int, OpenText] = {}
        self._rate = Bucket(_MOST_PER_S, _MOST_PER_S)
        self.left_out = 0

    def add(self, severity: int, text: str, number: int, part: int, now: float) -> None:
        """Take a STATUSTEXT.

        Args:
            severity: Its MAV_SEVERITY.
            text: Its words, at most 50 letters.
            number: Equal in all parts of one text; 0: it has one part.
            part: The place of this part, from 0.
            now: Monotonic time [s].
        """
        text = text[:_PART]
        if not number:
            self._keep(severity, text, now)
            return
        if part >= _MOST_PARTS:
            return
        if number not in self._open:
            if len(self._open) == _MOST_OPEN:
                self._end(next(iter(self._open)), now)
            self._open[number] = OpenText(severity=severity, since=now, parts={})
        self._open[number].parts[part] = text
        if self._open[number].whole:
            self._end(number, now)

    def step(self, now: float) -> None:
        """End the texts whose parts have not come in time."""
        for number in [n for n, each in self._open.items() if now - each.since >= _JOINED_S]:
            self._end(number, now)

    def since(self, time: float) -> list[VehicleText]:
        """The texts from a monotonic time [s] on."""
        return [each for each in self._texts if each.time >= time]

    def take(self) -> list[VehicleText]:
        """The texts since the last call."""
        taken = list(self._new)
        self._new.clear()
        return taken

    def _end(self, number: int, now: float) -> None:
        ended = self._open.pop(number)
        places = range(max(ended.parts) + 1)
        words = "".join(ended.parts.get(place, "...") for place in places)
        self._keep(ended.severity, words, now)

    def _keep(self, severity: int, words: str, now: float) -> None:
        words = plain(words).strip()[:_LONGEST]
        if not words or words.startswith(_REPEATED):
            return
        if any(each.text == words for each in self.since(now - _EACH_S)) or not self._rate.take(
            1.0, now
        ):
            self.left_out += 1
            return
        level = _SEVERITIES[min(severity, len(_SEVERITIES) - 1)]
        made = VehicleText(time=now, level=level, text=words)
        self._texts.append(made)
        self._new.append(made)
