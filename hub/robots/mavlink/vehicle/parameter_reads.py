"""Parameters that are read by name; pure.

A vehicle does not answer names that it does not have. Such a name is asked for four times, and
from then on every two seconds in turn: an answer may have been lost.
"""

from __future__ import annotations

import math
import struct
from collections import deque
from collections.abc import Iterable, Mapping
from typing import Final

from hub.robots.mavlink.wire.frames import MavlinkFrame

_EVERY_S: Final = 0.05
"""Time between two questions [s]."""
_AGAIN_S: Final = 2.0
"""Time between two questions for what did not come [s]."""
_TRIES: Final = 4
_LARGEST: Final = 1e9
"""Largest value of a parameter that is taken."""
_WHOLE: Final = {1: "B3x", 2: "b3x", 3: "H2x", 4: "h2x", 5: "I", 6: "i"}
"""Formats by MAV_PARAM_TYPE of whole numbers."""


def parameter_value(frame: MavlinkFrame, *, bytewise: bool) -> float:
    """The value in a PARAM_VALUE.

    Args:
        frame: The message.
        bytewise: Whether a whole number comes as the bytes of the field, as from PX4; else as its
            value, as from ArduPilot.
    """
    form = _WHOLE.get(frame["param_type"])
    if not bytewise or form is None:
        return float(frame["param_value"])
    return float(struct.unpack(f"<{form}", struct.pack("<f", frame["param_value"]))[0])


class ParameterReads:
    """The parameters of one vehicle that are read.

    Attributes:
        values: Their values, exactly as they came: 0.1 is the 32-bit float 0.100000001.
    """

    def __init__(self) -> None:
        self.values: dict[str, float] = {}
        self._current: Mapping[str, str] = {}
        self._tries: dict[str, int] = {}
        self._later: frozenset[str] = frozenset()
        self._left: deque[str] = deque()
        self._at = -math.inf

    @property
    def reading(self) -> bool:
        """Whether some were asked for less often than they should be."""
        return any(self._tries[name] > 0 for name in self._left if name not in self._later)

    @property
    def missing(self) -> tuple[str, ...]:
        """The names, in their present spelling, that were asked for and did not come."""
        if self.reading:
            return ()
        left = (name for name in self._left if name not in self._later)
        return tuple(dict.fromkeys(self._current.get(name, name) for name in left))

    def begin(
        self,
        names: Iterable[str],
        older: Mapping[str, str] | None = None,
        later: Iterable[str] = (),
    ) -> None:
        """Read these again.

        Args:
            names: Their present names.
            older: Their present names by names that older firmware has.
            later: Names that are read after these, and that nothing waits for.
        """
        self._current = dict(older or {})
        wanted = dict.fromkeys(names)
        aliases = [old for old, name in self._current.items() if name in wanted]
        self._later = frozenset(later)
        self._left = deque([*wanted, *aliases, *sorted(self._later)])
        self._tries = dict.fromkeys(self._left, _TRIES)

    def forget(self) -> None:
        """Read all of them again: the vehicle was booted, or is another one."""
        self.values.clear()
        self._left = deque(self._tries)
        self._tries = dict.fromkeys(self._left, _TRIES)

    def due(self, now: float) -> str:
        """The name to ask for now; empty: none."""
        hurries = any(self._tries[name] > 0 for name in self._left)
        if not self._left or now - self._at < (_EVERY_S if hurries else _AGAIN_S):
            return ""
        self._at = now
        later = frozenset[str]() if not self.reading else self._later
        name = next(each for each in self._left if each not in later)
        self._left.remove(name)
        self._left.append(name)
        self._tries[name] = max(0, self._tries[name] - 1)
        return name

    def take(self, name: str, value: float) -> None:
        """Take a PARAM_VALUE; others than the wanted ones, and no numbers, are left out."""
        if name not in self._tries or not abs(value) <= _LARGEST:
            return
        wanted = self._current.get(name, name)
        self.values[wanted] = value
        self._left = deque(each for each in self._left if self._current.get(each, each) != wanted)
