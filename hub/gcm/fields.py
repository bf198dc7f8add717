"""Kinds of fields that messages share, each with what it may hold; see `hub.ipc.formats.ranges`.

A field of another range declares it where it stands. `Known` kinds are NaN where a value is not
known.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from hub.ipc.formats.ranges import Most, Range, Text
from hub.ipc.formats.wire_types import Counted, Uint8, Uint32

FARTHEST_M: Final = 1e6
"""No place is farther than this from the origin along one axis [m]."""
LONGEST_M: Final = 1e10
"""No way is longer [m], not even one that leads to and fro between the farthest places."""
MOST_REPORTS: Final = 1000
"""Entries of the longest list that everybody takes, such as modules."""

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
"""A direction [rad]; a whole turn more than (-pi, pi] does no harm."""
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
"""A number at central, or a count that never ends."""
Count: TypeAlias = Annotated[int, Range(0, 1_000_000)]
"""How many."""
ProcessId: TypeAlias = Annotated[int, Range(0, 0x7FFF_FFFF)]

Name: TypeAlias = Annotated[str, Text(64)]
"""What something is called: a module, a message, a person."""
Names: TypeAlias = Annotated[str, Text(4000)]
"""Names with spaces between them."""
Sentence: TypeAlias = Annotated[str, Text(1000)]
"""Words for people, on one line."""
Lines: TypeAlias = Annotated[str, Text(1_000_000, lines=True)]
"""Several lines."""

Ranges: TypeAlias = Annotated[
    npt.NDArray[np.float32], Range(0.0, 1000.0, unit="m", nan=True, infinite=True)
]
"""What range sensors measure [m]; infinite: nothing is there, NaN: there is no sensor."""
Numbers: TypeAlias = Annotated[npt.NDArray[np.uint32], Counted(), Most(MOST_REPORTS)]
"""Numbers at central."""
Octets: TypeAlias = Annotated[npt.NDArray[np.uint8], Counted("length", "uint"), Most(1 << 26)]
"""A file or a picture."""
