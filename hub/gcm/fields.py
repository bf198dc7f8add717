"""Shared kinds of fields with their ranges; see `hub.ipc.formats.ranges`.

A field with another range declares it itself. `Known` kinds are NaN for an unknown value.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from hub.ipc.formats.ranges import Most, Range, Text
from hub.ipc.formats.wire_types import Counted, Uint8, Uint32

FARTHEST_M: Final = 1e6
"""Largest distance of a place from the origin, along one axis [m]."""
LONGEST_M: Final = 1e10
"""Longest path [m]: even one back and forth between the farthest places."""
MOST_REPORTS: Final = 1000
"""Most entries of a list, such as modules."""

Stamp: TypeAlias = Annotated[float, Range(0.0, 1e10, unit="s")]
"""Time since the epoch [s], until the year 2286."""
Seconds: TypeAlias = Annotated[float, Range(0.0, 1e9, unit="s")]
"""A span of time [s]."""
SecondsIfKnown: TypeAlias = Annotated[float, Range(0.0, 1e9, unit="s", nan=True)]

Metres: TypeAlias = Annotated[float, Range(-FARTHEST_M, FARTHEST_M, unit="m")]
"""A place along one axis [m]."""
MetresIfKnown: TypeAlias = Annotated[float, Range(-FARTHEST_M, FARTHEST_M, unit="m", nan=True)]
Length: TypeAlias = Annotated[float, Range(0.0, LONGEST_M, unit="m")]
"""A distance [m]."""
LengthIfKnown: TypeAlias = Annotated[float, Range(0.0, LONGEST_M, unit="m", nan=True)]

Radians: TypeAlias = Annotated[float, Range(-math.tau, math.tau, unit="rad")]
"""A direction [rad]; up to a whole turn beyond (-pi, pi]."""
RadiansIfKnown: TypeAlias = Annotated[float, Range(-math.tau, math.tau, unit="rad", nan=True)]

Speed: TypeAlias = Annotated[float, Range(-100.0, 100.0, unit="m/s")]
"""A velocity along one axis [m/s]."""
SpeedIfKnown: TypeAlias = Annotated[float, Range(-100.0, 100.0, unit="m/s", nan=True)]
TurnRate: TypeAlias = Annotated[float, Range(-100.0, 100.0, unit="rad/s")]
"""A velocity about one axis [rad/s]."""

Share: TypeAlias = Annotated[float, Range(0.0, 1.0, nearest=True)]
"""A part of a whole, 0 to 1."""
ShareIfKnown: TypeAlias = Annotated[float, Range(0.0, 1.0, nan=True)]

Flag: TypeAlias = Annotated[Uint8, Range(0, 1)]
"""1 for yes, 0 for no."""
Number: TypeAlias = Annotated[Uint32, Range(0, 0xFFFF_FFFF)]
"""A number at central, or an endless count."""
Count: TypeAlias = Annotated[int, Range(0, 1_000_000)]
"""A number of things."""
ProcessId: TypeAlias = Annotated[int, Range(0, 0x7FFF_FFFF)]

Name: TypeAlias = Annotated[str, Text(64)]
"""The name of a module, a message or a person."""
Names: TypeAlias = Annotated[str, Text(4000)]
"""Names with spaces between them."""
Sentence: TypeAlias = Annotated[str, Text(1000)]
"""Words for people, on one line."""
Lines: TypeAlias = Annotated[str, Text(1_000_000, lines=True)]
"""Several lines."""

Ranges: TypeAlias = Annotated[
    npt.NDArray[np.float32], Range(0.0, 1000.0, unit="m", nan=True, infinite=True)
]
"""Measurements of range sensors [m]; infinite: no obstacle, NaN: no sensor."""
Numbers: TypeAlias = Annotated[npt.NDArray[np.uint32], Counted(), Most(MOST_REPORTS)]
"""Numbers at central."""
Octets: TypeAlias = Annotated[npt.NDArray[np.uint8], Counted("length", "uint"), Most(1 << 26)]
"""A file or a picture."""
