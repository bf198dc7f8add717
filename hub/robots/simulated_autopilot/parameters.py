"""The parameters of a simulated autopilot, from `parameters.txt`; pure."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from hub.errors import AutopilotSettingError
from hub.nearest import did_you_mean
from hub.values import dataclass

_TABLE = Path(__file__).with_suffix(".txt")
_COLUMNS: Final = {"rover": 2, "sub": 3, "blimp": 4}
_NONE: Final = "-"
_REAL: Final = 9
"""MAV_PARAM_TYPE_REAL32; all others are whole numbers."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterEntry:
    """One parameter.

    Attributes:
        type: Its MAV_PARAM_TYPE.
        value: Its default.
    """

    type: int
    value: float


def default_parameters(kind: str) -> dict[str, ParameterEntry]:
    """The parameters of a kind of vehicle, by name."""
    column = _COLUMNS[kind]
    entries: dict[str, ParameterEntry] = {}
    for line in _TABLE.read_text("ascii").splitlines():
        words = line.split()
        if not line.startswith("#") and words[column] != _NONE:
            value = float32(float(words[column]))
            entries[words[0]] = ParameterEntry(type=int(words[1]), value=value)
    return entries


def float32(value: float) -> float:
    """The nearest 32-bit float, which is what MAVLink carries."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


class ParameterStore:
    """Values by name; they last over a restart of the vehicle."""

    def __init__(self, kind: str, settings: Mapping[str, float]) -> None:
        """Begin with the defaults.

        Args:
            kind: "rover", "sub" or "blimp".
            settings: Values that replace defaults.

        Raises:
            AutopilotSettingError: There is no such parameter.
        """
        self._entries = default_parameters(kind)
        self._values = {name: entry.value for name, entry in self._entries.items()}
        self.names: Final = tuple(self._entries)
        for name, value in settings.items():
            if not self.set(name, value):
                hint = did_you_mean(name, self.names)
                raise AutopilotSettingError(name, f"a {kind} has no such parameter{hint}")

    def __getitem__(self, name: str) -> float:
        """A value; 0: there is no such parameter."""
        return self._values.get(name, 0.0)

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def type(self, name: str) -> int:
        """The MAV_PARAM_TYPE of a parameter."""
        return self._entries[name].type

    def set(self, name: str, value: float) -> bool:
        """Change a value; returns whether there is such a parameter, and the value a number."""
        if name not in self._values or value != value or abs(value) > 3e38:
            return False
        self._values[name] = float32(value if self.type(name) == _REAL else round(value))
        return True
