"""Messages of a gamepad at another machine than the console: what it is, says, and who uses it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import numpy.typing as npt

from hub.gcm.fields import Flag, Name, Number, Numbers, Octets, Sentence
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import Counted, Wire

STATE_HZ = 50.0
"""How often a pad that is being used says its state [Hz]."""
ALIVE_HZ = 5.0
"""How often one says so that nobody touches [Hz]."""
DEVICE_HZ = 0.5
"""How often one says what it is [Hz]: so long a console that was opened later has to wait."""
CONSOLE_HZ = 1.0
"""How often a console that takes pads says whose it uses [Hz]."""
OLDEST_S = 0.25
"""Older states are dropped, and so long a silence of a pad that is being used lets go of it [s]."""
MOST_CONTROLS = 10_000
"""Axes, buttons, hats and balls of one pad."""
NO_VALUE = -(1 << 31)
"""Of an axis or a hat that has none: nothing has come yet, or a hat's centre."""


_Values = Annotated[npt.NDArray[np.int32], Counted(), Most(MOST_CONTROLS)]


def _no_bytes() -> npt.NDArray[np.uint8]:
    return np.zeros(0, np.uint8)


def _no_values() -> npt.NDArray[np.int32]:
    return np.zeros(0, np.int32)


def _no_numbers() -> npt.NDArray[np.uint32]:
    return np.zeros(0, np.uint32)


@dataclass(frozen=True, slots=True, kw_only=True)
class PadDevice:
    """What the gamepad is whose states follow; when it is plugged in and now and then.

    Attributes:
        session: Counts how often the sender began anew; its states name the same number.
        operator: Whose console it is for; empty: any at this hub.
        machine: Where it is plugged in, for people.
        name: What the device calls itself.
        vid: The vendor's number.
        pid: The product's number.
        serial: Its serial number; empty if it tells none.
        port: Where at that machine it is plugged in; empty if that is not known.
        bus: As Linux counts: 3 for USB, 5 for Bluetooth, 0 if it is not known.
        descriptor: The report descriptor, from which follows what controls it has, shape (n,).
    """

    session: Number
    operator: Name = ""
    machine: Name = ""
    name: Sentence = ""
    vid: Annotated[Number, Wire("ushort")] = 0
    pid: Annotated[Number, Wire("ushort")] = 0
    serial: Sentence = ""
    port: Sentence = ""
    bus: Annotated[Number, Wire("ubyte")] = 0
    descriptor: Annotated[Octets, Counted()] = field(default_factory=_no_bytes)


PAD_DEVICE = MessageDefinition(
    name="GCM_Pad_Device",
    type=PadDevice,
    plane=Plane.COMMAND,
    rate_hz=DEVICE_HZ,
    lifespan_s=2.0 / DEVICE_HZ,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PadState:
    """How all controls of a gamepad stand; each state says all, so that the newest is enough.

    Attributes:
        session: Which `PadDevice` it is of.
        active: 1 while something is moved or was in the last second: then the next state follows
            within 20 ms; else 0, and it follows within 200 ms. Where `values` is empty: 1 if the
            sender waits for the device and says so again every 2 s, 0 if it ends.
        values: One for each control of the descriptor, in its order, shape (n,); empty: the device
            is gone, or its sender ends. An axis, a hat: the newest raw number [device units] or
            `NO_VALUE`. A button: how often it went down or up, modulo 2^31, so that it is down
            when that is odd. A ball: the sum of its counts, modulo 2^32.
    """

    session: Number
    active: Flag = 0
    values: _Values = field(default_factory=_no_values)


PAD_STATE = MessageDefinition(
    name="GCM_Pad_State",
    type=PadState,
    plane=Plane.COMMAND,
    rate_hz=STATE_HZ,
    lifespan_s=OLDEST_S,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PadConsole:
    """A console that takes gamepads of other machines, and which it uses; for those who send them.

    Attributes:
        operator: Who sits there; pads for others it leaves out.
        taken: The numbers at central of their senders, shape (n,).
    """

    operator: Name = ""
    taken: Numbers = field(default_factory=_no_numbers)


PAD_CONSOLE = MessageDefinition(
    name="GCM_Pad_Console",
    type=PadConsole,
    plane=Plane.COMMAND,
    rate_hz=CONSOLE_HZ,
    lifespan_s=2.0 / CONSOLE_HZ,
)

MESSAGES = (PAD_DEVICE, PAD_STATE, PAD_CONSOLE)
