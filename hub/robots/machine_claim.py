"""The claim of one process on a robot: no second one of this machine drives it meanwhile.

| state | event | next state |
| --- | --- | --- |
| free | a process takes it | held; the system frees it when the process ends, however that is |
| held | another process asks | it gets the number of the process that has it |

The claim is a name of a local socket, which belongs to no file and no user. Where the system has no
such names, each process gets it. Another address of the same robot is another claim.
"""

from __future__ import annotations

import contextlib
import socket
import sys
from typing import Final

from hub.ipc.transport import file_descriptors

_ASKING: Final = 16
"""Most others that may ask who has it."""
_LONGEST: Final = 90
"""Most bytes of a name; the system takes 107."""


class MachineClaim:
    """The claim on one robot; used by one thread."""

    def __init__(self, kind: str, words: str) -> None:
        """Take the kind of what is claimed, and words for this one; nothing is claimed yet."""
        self._name = b"\0rune-" + f"{kind} ".encode() + words.encode()[-_LONGEST:]
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
            return f"process {file_descriptors.peer_of(asking)[0]} of this machine"
        return "another program of this machine"

    def close(self) -> None:
        """Let others have it."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def local_place(place: str) -> str:
    """A host with its port, the same for both names of this machine."""
    return place.replace("localhost:", "127.0.0.1:")
