"""`rune joytest`: what is plugged in, what it reports, and how layouts name its controls."""

from __future__ import annotations

import json
import shutil
import sys
import threading
import time
from collections.abc import Sequence
from typing import Any
from xml.sax.saxutils import quoteattr

from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.hid_reader import (
    Gone,
    HidReader,
    News,
    Opened,
    Refused,
    Scanned,
    controls_of,
    plugged_in,
)
from rune_tui.controls.joystick.inbox import Inbox
from rune_tui.controls.joystick.logical import LogicalJoystick
from rune_tui.controls.joystick.mappings import Mappings
from rune_tui.controls.joystick.matching import DeviceInfo
from rune_tui.controls.joystick.rights import RULE_FILE, udev_rule, udev_rules
from rune_tui.controls.joystick.store import CalibrationStore
from rune_tui.errors import DescriptorError
from rune_tui.layout.spec import ControlKind, ControlSpec, JoystickSpec
from rune_tui.visualizers.joystick import bar

NOTHING = "no joystick is plugged in"
_FRAME_S = 0.05
_RATE_S = 1.0
_BAR = 21
_MEANT = 0.6
"""How far a control has to be moved to be learned."""
_ENTER, _LEAVE = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
_HOME, _REST_OF_LINE, _BELOW = "\x1b[H", "\x1b[K", "\x1b[J"


def plugged_in_joysticks() -> tuple[DeviceInfo, ...]:
    """All that is plugged in and says that it is a joystick.

    Raises:
        HidMissingError: There is no hidapi.
    """
    return tuple(device for device in plugged_in() if device.joystick)


def described(device: DeviceInfo) -> dict[str, Any]:
    """What there is to know of a device, for programs; opens it for a moment."""
    controls: Sequence[PhysicalControl] = ()
    why = ""
    try:
        controls = Mappings().applied(device, controls_of(device))
    except PermissionError:
        why = f"no permission to read it; put into {RULE_FILE}: {udev_rule(device)}"
    except (OSError, DescriptorError) as error:
        why = f"it cannot be read: {error}"
    return {
        "name": device.name,
        "vid": f"{device.vid:04x}",
        "pid": f"{device.pid:04x}",
        "serial": device.serial,
        "port": device.port,
        "path": device.path,
        "trouble": why,
        "controls": [
            {
                "type": control.kind.value,
                "index": control.index,
                "usage": control.usage,
                "role": control.role,
                "min": control.minimum,
                "max": control.maximum,
            }
            for control in controls
        ],
    }


def listed(*, as_json: bool) -> str:
    """All joysticks, for people or for programs."""
    told = [described(device) for device in plugged_in_joysticks()]
    if as_json:
        return json.dumps(told, indent=2) + "\n"
    lines = []
    for each in told:
        lines.append(f"{each['vid']}:{each['pid']} {each['serial'] or '-'} {each['name']}")
        types = [control["type"] for control in each["controls"]]
        counts = ((types.count(kind.value), kind.value) for kind in ControlKind)
        has = ", ".join(f"{count} of type {kind}" for count, kind in counts if count)
        lines.append(f"  {each['path']}: {each['trouble'] or has}")
    return "\n".join(lines or [NOTHING]) + "\n"


def rules() -> str:
    """A file of rules with which users of this system may read the joysticks."""
    devices = plugged_in_joysticks()
    return udev_rules(devices) if devices else f"# {NOTHING}\n"


def watch() -> None:
    """Show what all joysticks report, until somebody ends it."""
    _follow(_Pictures())


def learn() -> None:
    """Write what a layout says of each control that is moved, until somebody ends it."""
    _follow(_Lines())


class Seat:
    """A device that is read, with all of its controls as a layout could use them."""

    def __init__(self, device: DeviceInfo) -> None:
        self.device = device
        self.why = "being opened"
        self.controls: tuple[PhysicalControl, ...] = ()
        self.raws: dict[int, int | None] = {}
        self.rate = 0.0
        self._joystick: LogicalJoystick | None = None
        self._counted = (0, 0.0)

    def opened(self, controls: tuple[PhysicalControl, ...], store: CalibrationStore) -> None:
        """It can be read."""
        self.why = ""
        self.controls = controls
        specs = tuple(
            ControlSpec(name=each.usage, kind=each.kind, usage=each.usage) for each in controls
        )
        self._joystick = LogicalJoystick(JoystickSpec(name="joytest", controls=specs, line=0))
        self._joystick.connect(controls, store.of(self.device.key))

    def take(self, inbox: Inbox, now: float) -> None:
        """What has come since the last call."""
        values = inbox.take()
        self.raws.update(values)
        if self._joystick is not None:
            self._joystick.feed(values, now)
        count, since = self._counted
        if now - since >= _RATE_S:
            self.rate = (inbox.reports - count) / (now - since) if since else 0.0
            self._counted = (inbox.reports, now)

    def value(self, position: int) -> float | None:
        """How far a control is moved, -1 to 1; None while nothing is known, and for hats."""
        values = self._joystick.values if self._joystick is not None else {}
        return values.get(self.controls[position].usage)

    def pushed(self, position: int) -> str:
        """Where a hat is pushed, in words."""
        values = self._joystick.values if self._joystick is not None else {}
        start = f"{self.controls[position].usage} "
        return " ".join(
            name.removeprefix(start)
            for name, value in values.items()
            if value and name.startswith(start)
        )


def lines_of(seat: Seat) -> list[str]:
    """A device in words and bars."""
    device = seat.device
    name = f"{device.vid:04x}:{device.pid:04x} {device.shown} {device.serial}".rstrip()
    if seat.why:
        return [name, f"  {seat.why}"]
    lines = [f"{name}: {seat.rate:.0f} reports a second"]
    for position, control in enumerate(seat.controls):
        raw = seat.raws.get(position)
        told = f"  {control.usage:16} {control.role:14} {'-' if raw is None else raw:>7}"
        value = seat.value(position)
        if control.kind is ControlKind.HAT:
            told += f"  {seat.pushed(position)}"
        elif value is None:
            told += "  nothing has come yet"
        else:
            told += f"  {bar(value, _BAR)} {value:+.2f}"
        lines.append(told)
    return lines


def control_line(control: PhysicalControl) -> str:
    """What a layout says to mean this control on any such device."""
    name = (control.role or control.usage).replace(" ", "-")
    which = (
        f"role={quoteattr(control.role)}" if control.role else f"usage={quoteattr(control.usage)}"
    )
    return f'  <control name={quoteattr(name)} type="{control.kind.value}" {which}/>'


def joystick_line(device: DeviceInfo) -> str:
    """What a layout says to mean this kind of device."""
    return f'<joystick name="pad" vid="{device.vid:04x}" pid="{device.pid:04x}">'


class Bench:
    """All joysticks that are plugged in, being read."""

    def __init__(self, reader: HidReader) -> None:
        self.seats: dict[str, Seat] = {}
        self._reader = reader
        self._store = CalibrationStore()
        self._mappings = Mappings()

    def turn(self, now: float) -> None:
        """Take what has come."""
        for news in self._reader.news():
            self._learn(news)
        for path, seat in self.seats.items():
            inbox = self._reader.inbox(path)
            if inbox is not None:
                seat.take(inbox, now)

    def _learn(self, news: News) -> None:
        match news:
            case Scanned(devices=devices):
                here = {device.path: device for device in devices if device.joystick}
                for path in [each for each in self.seats if each not in here]:
                    self._reader.stop(path)
                    del self.seats[path]
                for path, device in here.items():
                    self.seats.setdefault(path, Seat(device))
                    self._reader.read(device)
            case Opened(path=path, controls=controls) if path in self.seats:
                seat = self.seats[path]
                seat.opened(self._mappings.applied(seat.device, controls), self._store)
            case Refused(path=path) if path in self.seats:
                self._reader.stop(path)
                rule = f"; put into {RULE_FILE}: {udev_rule(self.seats[path].device)}"
                self.seats[path].why = f"{news.why}{rule if news.forbidden else ''}"
            case Gone(path=path) if path in self.seats:
                self._reader.stop(path)
                self.seats[path].why = "it is gone"


class _Pictures:
    """The whole terminal, again and again."""

    def begin(self) -> None:
        sys.stdout.write(_ENTER)

    def show(self, bench: Bench) -> None:
        columns, rows = shutil.get_terminal_size()
        lines = [line for seat in bench.seats.values() for line in lines_of(seat)]
        lines = [*(lines or [f"{NOTHING}; waiting for one"]), "", "ctrl+c ends this"][:rows]
        whole = "\n".join(f"{line[:columns]}{_REST_OF_LINE}" for line in lines)
        sys.stdout.write(f"{_HOME}{whole}{_BELOW}")
        sys.stdout.flush()

    def end(self) -> None:
        sys.stdout.write(_LEAVE)
        sys.stdout.flush()


class _Lines:
    """A line for each control, when it is moved for the first time."""

    def __init__(self) -> None:
        self._told: set[tuple[str, int]] = set()
        self._device = ""

    def begin(self) -> None:
        sys.stderr.write("move each control as far as it goes; ctrl+c ends this\n")

    def show(self, bench: Bench) -> None:
        for path, seat in bench.seats.items():
            for position, control in enumerate(seat.controls):
                moved = seat.pushed(position) or abs(seat.value(position) or 0.0) > _MEANT
                if moved and (path, position) not in self._told:
                    self._told.add((path, position))
                    self._tell(seat.device, control)

    def _tell(self, device: DeviceInfo, control: PhysicalControl) -> None:
        if device.path != self._device:
            self.end()
            self._device = device.path
            sys.stdout.write(f"{joystick_line(device)}\n")
        sys.stdout.write(f"{control_line(control)}\n")
        sys.stdout.flush()

    def end(self) -> None:
        if self._device:
            sys.stdout.write("</joystick>\n")
            sys.stdout.flush()
        self._device = ""


def _follow(output: _Pictures | _Lines) -> None:
    moved = threading.Event()
    reader = HidReader()
    bench = Bench(reader)
    reader.start(moved.set)
    output.begin()
    try:
        while True:
            moved.wait(_RATE_S)
            moved.clear()
            bench.turn(time.monotonic())
            output.show(bench)
            time.sleep(_FRAME_S)
    finally:
        output.end()
        reader.close()
