"""Reads and writes the parameters of a vehicle; pure.

One parameter after the other is written:

| state | event | next state |
| --- | --- | --- |
| SET | PARAM_SET was sent | SENT |
| SENT | a PARAM_VALUE of this name, or 0.5 s | READ: PARAM_REQUEST_READ is sent |
| READ | a PARAM_VALUE with the wanted value | the next parameter, SET |
| READ | another value, or 0.5 s; tries are left | SET |
| READ | the same; no try is left | the next parameter, SET; this one failed |
| any | a heartbeat of the armed vehicle | it ends; all that is left failed |
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from hub.plain_text import plain
from hub.robots.mavlink.asking.findings import ARMED, AUTOPILOT
from hub.robots.mavlink.asking.session import OutgoingMessage, addressed
from hub.robots.mavlink.vehicle.parameter_reads import parameter_value
from hub.robots.mavlink.wire.frames import MavlinkFrame
from hub.values import dataclass

MOST_PARAMETERS: Final = 4096
"""Most parameters of a vehicle; autopilots have up to 1500."""
_LONGEST_NAME: Final = 16
_AGAIN_S: Final = 0.5
"""Silence after which the same is asked again [s]."""
_AT_ONCE: Final = 20
"""Most requests at once."""
_TRIES: Final = 5
_PX4: Final = 12
"""MAV_AUTOPILOT_PX4, which sends the bits of whole numbers in place of their values."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One parameter of a vehicle.

    Attributes:
        name: Its name.
        value: Its value, a 32-bit float.
        kind: Its MAV_PARAM_TYPE.
    """

    name: str
    value: float
    kind: int


def same_value(one: float, other: float) -> bool:
    """Whether two values are the same as 32-bit floats."""
    return math.isclose(one, other, rel_tol=1e-6, abs_tol=1e-12)


class ParameterReading:
    """Reads parameters; a `VehicleQuestion`.

    Attributes:
        values: What was read, by name.
        total: How many of the vehicle's are read; 0: not known.
        has_more: Whether it says that it has more than any vehicle has.
    """

    def __init__(self, system: int, names: Sequence[str] = (), autopilot: int = 0) -> None:
        """Take what to read.

        Args:
            system: Number of the vehicle.
            names: Names; none: all.
            autopilot: Its MAV_AUTOPILOT.
        """
        self._system, self._autopilot = system, autopilot
        self._names = tuple(dict.fromkeys(names))
        self.values: dict[str, Parameter] = {}
        self.total = 0
        self.has_more = False
        self._places: set[int] = set()
        self._next = -math.inf
        self._tries = _TRIES

    @property
    def missing(self) -> list[str]:
        """Names that the vehicle did not answer."""
        return [name for name in self._names if name not in self.values]

    @property
    def done(self) -> bool:
        """Whether all was read, or no try is left."""
        return self._tries < 0 or self.complete

    @property
    def complete(self) -> bool:
        """Whether all was read."""
        if self._names:
            return not self.missing
        return 0 < self.total == len(self._places)

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""
        if frame.name != "PARAM_VALUE" or not _is_from(frame, self._system):
            return
        name, count, place = frame["param_id"], frame["param_count"], frame["param_index"]
        if self._names:
            self._take(name, frame, now, wanted=name in self._names)
            return
        self.has_more = self.has_more or count > MOST_PARAMETERS
        self.total = min(MOST_PARAMETERS, max(self.total, count))
        new = place < self.total and place not in self._places
        if new:
            self._places.add(place)
        self._take(name, frame, now, wanted=new)

    def due(self, now: float) -> Iterator[OutgoingMessage]:
        """The messages to send now."""
        if now < self._next or self.done:
            return
        self._next = now + _AGAIN_S
        self._tries -= 1
        if self._tries < 0:
            return
        if self._names:
            for name in self.missing[:_AT_ONCE]:
                yield addressed("PARAM_REQUEST_READ", self._system, param_index=-1, param_id=name)
        elif not self.total:
            yield addressed("PARAM_REQUEST_LIST", self._system)
        else:
            left = [place for place in range(self.total) if place not in self._places]
            for place in left[:_AT_ONCE]:
                yield addressed("PARAM_REQUEST_READ", self._system, param_index=place)

    def _take(self, name: str, frame: MavlinkFrame, now: float, *, wanted: bool) -> None:
        if not wanted:
            return
        kind = frame["param_type"]
        value = parameter_value(frame, bytewise=self._autopilot == _PX4)
        shown = plain(name)[:_LONGEST_NAME]
        self.values[shown] = Parameter(name=shown, value=value, kind=kind)
        self._next, self._tries = now + _AGAIN_S, _TRIES
        if self._names and len(self.missing) % _AT_ONCE == 0:
            self._next = now


class ParameterWriting:
    """Writes parameters, and reads each back; a `VehicleQuestion`.

    Attributes:
        written: Names whose new value the vehicle confirmed.
        failed: Why others were not, by name.
    """

    def __init__(self, system: int, changes: Sequence[Parameter]) -> None:
        """Take the new values; the kinds have to be those of the vehicle."""
        self._system = system
        self._left = list(changes)
        self.written: list[str] = []
        self.failed: dict[str, str] = {}
        self._step = "set"
        self._next = -math.inf
        self._tries = _TRIES
        self._last: float | None = None

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return not self._left

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""
        if not self._left or not _is_from(frame, self._system):
            return
        if frame.name == "HEARTBEAT" and frame["base_mode"] & ARMED:
            self.failed |= dict.fromkeys((each.name for each in self._left), "it was armed")
            self._left.clear()
        elif frame.name == "PARAM_VALUE" and frame["param_id"] == self._left[0].name:
            self._value(frame["param_value"], now)

    def due(self, now: float) -> Iterator[OutgoingMessage]:
        """The messages to send now."""
        if not self._left or now < self._next:
            return
        wanted = self._left[0]
        self._next = now + _AGAIN_S
        if self._step == "read":
            self._step = "reading"
            yield addressed(
                "PARAM_REQUEST_READ", self._system, param_index=-1, param_id=wanted.name
            )
            return
        if self._step == "sent":  # it has not answered
            self._step, self._next = "read", now
            return
        self._tries -= 1
        if self._tries < 0:
            self._end(now)
            return
        self._step = "sent"
        yield addressed(
            "PARAM_SET",
            self._system,
            param_id=wanted.name,
            param_value=wanted.value,
            param_type=wanted.kind,
        )

    def _value(self, value: float, now: float) -> None:
        self._last = value
        if self._step == "sent":
            self._step, self._next = "read", now
        elif self._step == "reading":
            if same_value(value, self._left[0].value):
                self.written.append(self._left[0].name)
                self._proceed(now)
            else:
                self._step, self._next = "set", now

    def _end(self, now: float) -> None:
        kept = "it does not answer" if self._last is None else f"it keeps {shown(self._last)}"
        self.failed[self._left[0].name] = kept
        self._proceed(now)

    def _proceed(self, now: float) -> None:
        self._left.pop(0)
        self._step, self._next = "set", now
        self._tries, self._last = _TRIES, None


def shown(value: float) -> str:
    """A 32-bit float with as few digits as say it."""
    value = ctypes.c_float(value).value
    if not math.isfinite(value):
        return repr(value)
    short = next(
        (
            near
            for digits in range(1, 10)
            if ctypes.c_float(near := float(f"{value:.{digits}g}")).value == value
        ),
        value,
    )
    return repr(short).removesuffix(".0")


def _is_from(frame: MavlinkFrame, system: int) -> bool:
    return frame.system == system and frame.component == AUTOPILOT


def changes_of(values: Mapping[str, float], present: Mapping[str, Parameter]) -> list[Parameter]:
    """The parameters whose present value is another one; unknown names are left out."""
    return [
        Parameter(name=name, value=value, kind=present[name].kind)
        for name, value in values.items()
        if name in present and not same_value(present[name].value, value)
    ]
