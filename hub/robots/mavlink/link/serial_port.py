"""A link over a serial port."""

from __future__ import annotations

import errno
import os
from typing import TYPE_CHECKING, Final

from hub.robots.mavlink.link.byte_link import AT_ONCE, ByteLink

if TYPE_CHECKING:
    import serial

_NO_PORT: Final = "it is no serial port; correct the address"
_FAULTS: Final = {
    errno.ENOTTY: _NO_PORT,
    errno.EINVAL: _NO_PORT,
    errno.EISDIR: _NO_PORT,
    errno.EIO: "it was unplugged",
    errno.ENOENT: "it is not there; plug it in, or correct the address",
    errno.EACCES: "this user may not use it; add the user to the group that owns it, usually "
    "'dialout', and log in again",
    errno.EBUSY: "another program uses it; end that program",
    errno.EAGAIN: "another program uses it; end that program",
}


class SerialLink(ByteLink):
    """A serial port; pyserial opens it."""

    def __init__(self, path: str, baud: int) -> None:
        """Take its path and its rate; nothing is opened yet."""
        super().__init__()
        self._path, self._baud = path, baud
        self._port: serial.Serial | None = None

    def _open(self) -> None:
        try:
            import termios

            import serial
        except ImportError as fault:
            text = "pyserial is missing: pip install 'robot-user-nexus[mavlink]'"
            raise OSError(0, text) from fault
        try:
            self._port = serial.Serial(self._path, self._baud, timeout=0, exclusive=True)
        except (serial.SerialException, termios.error) as fault:
            number = _number(fault)
            raise OSError(number, _FAULTS.get(number, str(fault))) from fault
        except ValueError as fault:
            raise OSError(0, str(fault)) from fault
        os.set_blocking(self._port.fileno(), False)

    def _receive(self) -> bytes:
        if self._port is None:
            raise BlockingIOError
        data = os.read(self._port.fileno(), AT_ONCE)
        if not data:  # with VMIN 0 the system says so when nothing came
            if not os.path.exists(self._path):  # noqa: PTH110 - never raises
                raise OSError(errno.ENOENT, "it was unplugged")
            raise BlockingIOError
        return data

    def _send(self, data: bytes) -> int:
        return os.write(self._port.fileno(), data) if self._port is not None else 0

    def _file(self) -> int:
        return int(self._port.fileno()) if self._port is not None else -1

    def _shut(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None


def _number(fault: BaseException | None) -> int:
    """The error number of a fault, or of the one behind it; 0: it has none."""
    while fault is not None:
        if fault.args and isinstance(fault.args[0], int):
            return fault.args[0]
        fault = fault.__context__
    return 0
