"""The claim of one process on a vehicle: no second one of this machine sends to it meanwhile.

| state | event | next state |
| --- | --- | --- |
| free | a process takes it | held; the system frees it when the process ends, however that is |
| held | another process asks | it gets the number of the process that has it |

The claim is a name of a local socket, which belongs to no file and no user. Where the system has no
such names, each process gets it. Another address of the same vehicle is another claim.
"""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import sys
from typing import Final

from hub.robots.mavlink.link.address import VehicleAddress, VehicleLinkKind

_CREDENTIALS: Final = struct.Struct("3i")
_ASKING: Final = 16
"""Most others that may ask who has it."""
_LONGEST: Final = 90
"""Most bytes of a name; the system takes 107."""


class VehicleClaim:
    """The claim on one vehicle; used by one thread."""

    def __init__(self, address: VehicleAddress, system: int) -> None:
        """Take the vehicle's address and its number; nothing is claimed yet."""
        self._name = _name(address, system)
        self._socket: socket.socket | None = None

    def take(self) -> bool:
        """Claim it, unless it is claimed; returns whether this process has it."""
        if self._socket is not None or sys.platform != "linux":
            return True
        made = socket.socket(socket.AF_UNIX)
        try:
            made.bind(self._name)
            made.listen(_ASKING)
        except OSError:
            made.close()
            return False
        self._socket = made
        return True

    def owner(self) -> str:
        """The process that has it, in words."""
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX) as asking:
            asking.settimeout(0.0)
            asking.connect(self._name)
            size = _CREDENTIALS.size
            said = asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
            number, _, _ = _CREDENTIALS.unpack(said)
            return f"process {number} of this machine"
        return "another program of this machine"

    def close(self) -> None:
        """Let others have it."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _name(address: VehicleAddress, system: int) -> bytes:
    serial = address.kind is VehicleLinkKind.SERIAL
    place = os.path.realpath(address.host) if serial else f"{address.host}:{address.port}"
    local = place.replace("localhost:", "127.0.0.1:")
    return b"\0rune-vehicle " + f"{system} {address.kind.value} {local}".encode()[-_LONGEST:]
