"""Virtual joysticks: /dev/hidraw* nodes that exist only for the programs that a test starts.

libumockdev lays its own /sys and /dev/hidraw* under a program through LD_PRELOAD; the program and
its libraries are as they always are. On Debian it is in the package umockdev.
"""

from __future__ import annotations

import ctypes
import json
import os
import select
import struct
import tempfile
import time
from pathlib import Path
from typing import Any

import pytest

from tests.support.waiting import Limit

DEVICES = Path(__file__).parents[1] / "data" / "hid"
MISSING = "libumockdev is not installed (Debian: apt-get install umockdev): NO VIRTUAL JOYSTICK"
_PRELOAD = "libumockdev-preload.so.0"
_USB = 3
_LONGEST_DESCRIPTOR = 4096


def library() -> ctypes.CDLL | None:
    """libumockdev; None where it, or what is laid under programs, is not installed."""
    try:
        ctypes.CDLL(_PRELOAD, mode=os.RTLD_LAZY)
        loaded = ctypes.CDLL("libumockdev.so.0")
    except OSError:
        return None
    loaded.umockdev_testbed_new.restype = ctypes.c_void_p
    loaded.umockdev_testbed_get_root_dir.restype = ctypes.c_char_p
    return loaded


needs_virtual_devices = pytest.mark.skipif(library() is None, reason=MISSING)


class _Fault(ctypes.Structure):
    """GLib's GError."""

    _fields_ = (
        ("domain", ctypes.c_uint32),
        ("code", ctypes.c_int),
        ("message", ctypes.c_char_p),
    )


class VirtualBed:
    """A machine's joysticks; programs that are started with `environment` see nothing else."""

    def __init__(self) -> None:
        loaded = library()
        assert loaded is not None, MISSING
        self._library = loaded
        before = dict(os.environ)
        self._bed = ctypes.c_void_p(loaded.umockdev_testbed_new())
        self.root = Path(loaded.umockdev_testbed_get_root_dir(self._bed).decode())
        # It is for the programs that a test starts, not for the test.
        if "UMOCKDEV_DIR" not in before:
            os.environ.pop("UMOCKDEV_DIR", None)
        (self.root / "sys/class").mkdir(parents=True, exist_ok=True)
        self._used = 0

    @property
    def environment(self) -> dict[str, str]:
        """What the program under test needs."""
        return {"UMOCKDEV_DIR": str(self.root), "LD_PRELOAD": _PRELOAD}

    def plug(self, kind: str, *, port: int = 1, serial: str = "") -> VirtualDevice:
        """Plug a device in.

        Args:
            kind: Which of the devices that the tests have.
            port: Where.
            serial: Its serial number.
        """
        said: dict[str, Any] = json.loads((DEVICES / f"{kind}.json").read_text())
        # umockdev cannot take the number of a node again, so each has its own.
        number, self._used = self._used, self._used + 1
        return VirtualDevice(self, said, number, port, serial)

    def call(self, function: str, *arguments: Any) -> None:
        """Call the library, and fail as it does."""
        fault = ctypes.POINTER(_Fault)()
        done = getattr(self._library, f"umockdev_testbed_{function}")
        assert done(self._bed, *arguments, ctypes.byref(fault)), fault.contents.message

    def master_of(self, node: str) -> int:
        """The end of a node at which reports are written."""
        return int(self._library.umockdev_testbed_get_dev_fd(self._bed, node.encode()))

    def remove(self, path: str) -> None:
        """Take a device out of /sys."""
        self._library.umockdev_testbed_remove_device(self._bed, path.encode())

    def close(self) -> None:
        """Forget everything."""
        ctypes.CDLL("libgobject-2.0.so.0").g_object_unref(self._bed)


class VirtualDevice:
    """A device that is plugged in.

    Attributes:
        reports: What was recorded of such a device.
    """

    def __init__(
        self, bed: VirtualBed, said: dict[str, Any], number: int, port: int, serial: str
    ) -> None:
        self.reports = [bytes.fromhex(each) for each in said["reports"]]
        self._bed = bed
        self._number = number
        self._name = f"hidraw{number}"
        self._descriptor = bytes.fromhex(said["report_descriptor"])
        self._numbers = (said["bus"], int(said["vid"], 16), int(said["pid"], 16))
        described, self._above = self._described(said["name"], port, serial)
        self._place = self._above[0]
        bed.call("add_from_string", described.encode())
        with tempfile.NamedTemporaryFile("w", suffix=".ioctl") as file:
            file.write(self._answers())
            file.flush()
            bed.call("load_ioctl", f"/dev/{self._name}".encode(), file.name.encode())
        self._master = bed.master_of(f"/dev/{self._name}")
        self._terminal = str((bed.root / "dev" / self._name).readlink())
        # hidapi finds a device's strings by the number of its node, which is the terminal's.
        status = Path(self._terminal).stat().st_rdev
        self._link = bed.root / f"sys/dev/char/{os.major(status)}:{os.minor(status)}"
        self._link.parent.mkdir(parents=True, exist_ok=True)
        self._link.unlink(missing_ok=True)
        self._link.symlink_to(f"../..{self._place}")
        self._slave = os.open(self._terminal, os.O_RDWR | os.O_NOCTTY)
        self._waiting = select.poll()
        self._waiting.register(self._slave, select.POLLIN)

    def send(self, report: bytes, timeout: float = 10.0) -> None:
        """One report, as soon as the program has read the one before."""
        limit = Limit(timeout)
        while self.unread:
            assert not limit.over, f"nobody reads {self._name}"
            time.sleep(0.0005)
        os.write(self._master, report)

    @property
    def unread(self) -> bool:
        """Whether the program has not read the last report yet."""
        return bool(self._waiting.poll(0))

    def forbid(self) -> None:
        """Nobody but root may read it any more."""
        Path(self._terminal).chmod(0o600)

    def unplug(self) -> None:
        """Pull it out."""
        os.close(self._slave)
        root = self._bed.root
        for above in self._above:
            self._bed.remove(f"/sys{above}")
        # umockdev leaves these behind.
        left = [f"sys/dev/char/240:{self._number}", f"dev/{self._name}", f"dev/.node/{self._name}"]
        left.append(f"dev/.ptymap/{self._terminal.replace('/', '_')}")
        for link in (self._link, *(root / each for each in left)):
            link.unlink(missing_ok=True)
        # umockdev will close this number itself; until then it must not be the terminal, so that
        # the program sees the end of it, as it would of a device.
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, self._master)
        os.close(null)

    def _described(self, name: str, port: int, serial: str) -> tuple[str, list[str]]:
        """The device in umockdev's words, and its places below /sys, the innermost first."""
        bus, vid, pid = self._numbers
        kernel = f"{bus:04X}:{vid:04X}:{pid:04X}.{self._number + 1:04X}"
        usb = f"/devices/pci0000:00/0000:00:14.0/usb1/1-{port}"
        above = f"{usb}/1-{port}:1.0" if bus == _USB else "/devices/virtual/misc/uhid"
        place = f"{above}/{kernel}/hidraw/{self._name}"
        text = f"""P: {place}
N: {self._name}
E: DEVNAME=/dev/{self._name}
E: MAJOR=240
E: MINOR={self._number}
E: SUBSYSTEM=hidraw
A: dev=240:{self._number}\\n
L: device=../../../{kernel}

P: {above}/{kernel}
E: DRIVER=hid-generic
E: HID_ID={bus:04X}:{vid:08X}:{pid:08X}
E: HID_NAME={name}
E: HID_PHYS=usb-0000:00:14.0-{port}/input0
E: HID_UNIQ={serial}
E: SUBSYSTEM=hid
H: report_descriptor={self._descriptor.hex().upper()}

"""
        if bus == _USB:
            text += f"""P: {usb}/1-{port}:1.0
E: DEVTYPE=usb_interface
E: SUBSYSTEM=usb
A: bInterfaceNumber=00\\n

P: {usb}
E: DEVTYPE=usb_device
E: SUBSYSTEM=usb
E: BUSNUM=001
E: DEVNUM={self._number + 2:03d}
A: manufacturer=Test\\n
A: product={name}\\n
A: serial={serial}\\n
A: bcdDevice=0100\\n
A: idVendor={vid:04x}\\n
A: idProduct={pid:04x}\\n

"""
        return text, [place, f"{above}/{kernel}", *((above, usb) if bus == _USB else ())]

    def _answers(self) -> str:
        """What the kernel answers when asked for the descriptor (linux/hidraw.h)."""
        length = struct.pack("<I", len(self._descriptor))
        padded = length + self._descriptor.ljust(_LONGEST_DESCRIPTOR, b"\x01")
        about = struct.pack("<IHH", *self._numbers)
        return (
            f"@DEV /dev/{self._name}\n"
            f"HIDIOCGRDESCSIZE 0 {length.hex().upper()}\n"
            f"HIDIOCGRDESC 0 {padded.hex().upper()}\n"
            f"HIDIOCGRAWINFO 0 {about.hex().upper()}\n"
        )
