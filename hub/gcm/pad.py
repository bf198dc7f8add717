"""Messages of a gamepad at another machine than the console: its kind, its state, and its users."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated

import numpy as np
import numpy.typing as npt

from hub.gcm.fields import Flag, Name, Number, Numbers, Octets, Sentence
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import Counted, Wire
from hub.values import dataclass

STATE_HZ = 50.0
"""Rate of states of a pad in use [Hz]."""
ALIVE_HZ = 5.0
"""Rate of states of an idle pad [Hz]."""
DEVICE_HZ = 0.5
"""Rate of `PadDevice` [Hz]; a console that starts later waits one period at most."""
CONSOLE_HZ = 1.0
"""Rate of `PadConsole` [Hz]."""
OLDEST_S = 0.25
"""Age from which states are dropped, and silence after which a pad in use is released [s]."""
MOST_CONTROLS = 10_000
"""Most axes, buttons, hats and balls of one pad."""
NO_VALUE = -(1 << 31)
"""The value of an axis without data, or of a centred hat."""


_Values = Annotated[npt.NDArray[np.int32], Counted(), Most(MOST_CONTROLS)]


def _no_bytes() -> npt.NDArray[np.uint8]:
    return np.zeros(0, np.uint8)


def _no_values() -> npt.NDArray[np.int32]:
    return np.zeros(0, np.int32)


def _no_numbers() -> npt.NDArray[np.uint32]:
    return np.zeros(0, np.uint32)


@dataclass(frozen=True, slots=True, kw_only=True)
class PadDevice:
    """A gamepad; sent when it is plugged in, and at `DEVICE_HZ`.

    Attributes:
        session: Counts the sender's restarts; its states have the same number.
        operator: Operator of the console it is for; empty: any at this hub.
        machine: Its machine, for people.
        name: The device's own name.
        vid: The vendor's number.
        pid: The product's number.
        serial: Its serial number; empty: none.
        port: Its port at that machine; empty: not known.
        bus: Linux's number of the bus: 3 for USB, 5 for Bluetooth, 0: not known.
        descriptor: The report descriptor, which defines its controls, shape (n,).
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
    """The state of all controls of a gamepad; the newest one is enough.

    Attributes:
        session: Number of its `PadDevice`.
        active: 1: a control moved in the last second, and the next state follows within 20 ms;
            0: it follows within 200 ms. With empty `values`: 1: the sender waits for the device,
            and repeats this every 2 s; 0: it ends.
        values: One for each control of the descriptor, in its order, shape (n,); empty: the device
            is gone, or its sender ends. An axis, a hat: the newest raw number [device units] or
            `NO_VALUE`. A button: the count of its changes, modulo 2^31; odd: it is down.
            A ball: the sum of its counts, modulo 2^32.
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
    """A console and the gamepads of other machines that it uses; for their senders.

    Attributes:
        operator: Its operator; it ignores pads for others.
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
