"""The messages of good traffic: each carries its number and when it was sent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hub.ipc.definition import Keep, MessageDefinition, Plane


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """Something numbered.

    Attributes:
        number: Counts what its module wanted to publish under this name, from 0; other than the
            bus's own sequence it does not depend on connections.
        sent_ns: When, on this machine's monotonic clock [ns].
        size: Bytes of filler.
        filler: Shape (size,).
    """

    number: int
    sent_ns: int
    size: int
    filler: npt.NDArray[np.uint8]


_FORMAT = "{ulong,long,uint,<ubyte:3>}"
EVENT = MessageDefinition(name="S_Event", format=_FORMAT, type=Sample, keep=Keep.ALL)
COMMAND = MessageDefinition(
    name="S_Command",
    format=_FORMAT,
    type=Sample,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=0.3,
)
PICTURE = MessageDefinition(
    name="S_Picture", format=_FORMAT, type=Sample, keep=Keep.NEWEST, plane=Plane.PICTURE
)
ASK = MessageDefinition(name="S_Ask", format=_FORMAT, type=Sample)
ANSWER = MessageDefinition(name="S_Answer", format=_FORMAT, type=Sample)
BROADCASTS = {definition.name: definition for definition in (EVENT, COMMAND, PICTURE)}
PICTURE_BYTES = 57_600


def sample(number: int, sent_ns: int, size: int) -> Sample:
    """A sample with filler that depends on its number."""
    filler = np.full(size, number % 251, np.uint8)
    return Sample(number=number, sent_ns=sent_ns, size=size, filler=filler)
