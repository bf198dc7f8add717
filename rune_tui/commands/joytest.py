"""`rune joytest`: the joysticks of this machine, their reports, and names for layouts."""

from __future__ import annotations

import json
import shutil
import sys
import textwrap
import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any
from xml.sax.saxutils import quoteattr

from rune_tui.controls.devices import local_devices
from rune_tui.controls.devices.device_reader import (
    DeviceReader,
    Gone,
    News,
    Opened,
    Refused,
    Scanned,
)
from rune_tui.controls.devices.inbox import Inbox
from rune_tui.controls.devices.local_devices import controls_of, joysticks_here, lists_devices
from rune_tui.controls.devices.matching import DeviceInfo, assigned
from rune_tui.controls.devices.udev_rules import rule_advice, udev_rules
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.controls.joystick.logical import LogicalJoystick
from rune_tui.controls.joystick.mappings import Mappings
from rune_tui.controls.joystick.shaping import Shape
from rune_tui.errors import DescriptorError
from rune_tui.layout.spec import ControlKind, ControlSpec, JoystickSpec
from rune_tui.visualizers.words.joystick import bar

_NOTHING = "no joystick is plugged in"
_UNKNOWN = (
    "not known whether a joystick is plugged in: this system lists no devices at all, "
    "as in a container without /dev/hidraw* and /dev/input"
)
_FRAME_S = 0.05
_RATE_S = 1.0
_BAR = 21
_CURVE = 16
_HEIGHTS = "·▁▂▃▄▅▆▇█"
_MEANT = 0.6
"""Least deflection of a control that is learned."""
_NOT_IN_LAYOUT = JoystickSpec(name="")
_ENTER, _LEAVE = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
_HOME, _REST_OF_LINE, _BELOW = "\x1b[H", "\x1b[K", "\x1b[J"


def described(number: int, device: DeviceInfo) -> dict[str, Any]:
    """The facts of a device, for programs; opens the device for a moment."""
    controls: Sequence[PhysicalControl] = ()
    why = ""
    try:
        controls = Mappings().applied(device, controls_of(device))
    except PermissionError:
        why = f"no permission to read it; {rule_advice(device)}"
    except (OSError, DescriptorError) as error:
        why = f"it cannot be read: {error}"
    return {
        "number": number,
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


def absence() -> str:
    """What it means that no joystick is found, in a sentence."""
    return _NOTHING if lists_devices() else _UNKNOWN


def listed(*, as_json: bool) -> str:
    """All joysticks, as text or as JSON; null where the system lists no devices at all."""
    line = [described(number, device) for number, device in enumerate(joysticks_here(), 1)]
    if as_json:
        return json.dumps(line if line or lists_devices() else None, indent=2) + "\n"
    lines = []
    for each in line:
        which = f"{each['vid']}:{each['pid']} {each['serial'] or '-'} {each['name']}"
        lines.append(f"{each['number']}  {which}")
        types = [control["type"] for control in each["controls"]]
        counts = ((types.count(kind.value), kind.value) for kind in ControlKind)
        has = ", ".join(f"{count} of type {kind}" for count, kind in counts if count)
        lines.append(f"   {each['path']}: {each['trouble'] or has}")
    return "\n".join(lines or [absence()]) + "\n"


def rules() -> str:
    """A udev rules file that lets users of this system read the joysticks."""
    devices = joysticks_here()
    return udev_rules(devices) if devices else f"# {absence()}\n"


def watch(joysticks: Sequence[JoystickSpec] | None = None) -> None:
    """Show the reports of all joysticks until Ctrl-C.

    Args:
        joysticks: Joysticks of a layout, to show the values there; None: without a layout.
    """
    _follow(_Pictures(), joysticks)


def learn() -> None:
    """Write the layout's line for each control that is moved, until Ctrl-C."""
    _follow(_Lines())


class TestedDevice:
    """A device and its reports, with all controls that a layout could use."""

    def __init__(self, device: DeviceInfo) -> None:
        self.device = device
        self.why = "being opened"
        self.controls: tuple[PhysicalControl, ...] = ()
        self.raws: dict[int, int | None] = {}
        self.rate = 0.0
        self.joystick = LogicalJoystick(JoystickSpec(name="joytest"))
        self._counted = (0, 0.0)

    def opened(
        self,
        controls: tuple[PhysicalControl, ...],
        store: CalibrationStore,
        spec: JoystickSpec | None = None,
    ) -> None:
        """Note that the device is open.

        Args:
            controls: Its controls.
            store: Calibrations.
            spec: Its joystick in the layout; None: all controls, by usage.
        """
        self.why = ""
        self.controls = controls
        specs = tuple(
            ControlSpec(name=each.usage, kind=each.kind, usage=each.usage) for each in controls
        )
        self.joystick = LogicalJoystick(spec or JoystickSpec(name="joytest", controls=specs))
        self.joystick.connect(controls, store.of(self.device.key))

    def take(self, inbox: Inbox, now: float) -> None:
        """Take the reports since the last call."""
        values = inbox.take()
        self.raws.update(values)
        self.joystick.feed(values, now)
        count, since = self._counted
        if now - since >= _RATE_S:
            self.rate = (inbox.reports - count) / (now - since) if since else 0.0
            self._counted = (inbox.reports, now)

    def moved(self, position: int) -> bool:
        """Whether a control is moved far enough to be learned."""
        values = self.joystick.values
        return any(abs(values.get(n, 0.0)) > _MEANT for n in self.joystick.shown_at(position))


def lines_of(one: TestedDevice) -> list[str]:
    """The lines of a device: words and bars."""
    device = one.device
    name = f"{device.vid:04x}:{device.pid:04x} {device.shown} {device.serial}".rstrip()
    if one.why:
        return [name, f"  {one.why}"]
    lines = [f"{name}: {one.rate:.0f} reports a second"]
    for position, control in enumerate(one.controls):
        raw = one.raws.get(position)
        line = f"  {control.usage:16} {control.role:14} {'-' if raw is None else raw:>7}"
        shown = one.joystick.shown_at(position)
        if control.kind is ControlKind.HAT:
            shown = shown[:1]  # one line for all directions
        lines += [f"{line}  {made_of(one, position, each)}" for each in shown]
        lines += [] if shown else [f"{line}  not in the layout"]
    return lines


def made_of(one: TestedDevice, position: int, name: str) -> str:
    """The layout's value of a device's control."""
    joystick, control = one.joystick, one.controls[position]
    own = name == control.usage
    if control.kind is ControlKind.HAT:
        pushed = [each for each in joystick.shown_at(position) if joystick.values.get(each)]
        called = "" if name.startswith(control.usage) else f"{name.rpartition(' ')[0]} "
        return called + " ".join(each.rpartition(" ")[2] for each in pushed)
    value = joystick.values.get(name)
    called = "" if own else f"{name:14} "
    if value is None:
        return f"{called}nothing has come yet"
    line = f"{called}{bar(value, _BAR)} {value:+.2f}"
    axis = joystick.axes.get(name)
    if axis is None:
        return line
    about = f"dead zone {axis.shape.dead_zone:.2f}, expo {axis.shape.expo:.2f}"
    return f"{line} of {axis.share + 0.0:+.2f}  {curve(axis.shape)}  {about}"  # no -0.00


def fold(line: str, columns: int) -> list[str]:
    """A line in rows of this width [columns]; rows after the first are indented."""
    return textwrap.wrap(line, max(20, columns), subsequent_indent=" " * 8) or [""]


def curve(shape: Shape) -> str:
    """The response curve of an axis, from rest to end."""
    shares = (column / (_CURVE - 1) for column in range(_CURVE))
    return "".join(_HEIGHTS[round(shape.shaped(share) * (len(_HEIGHTS) - 1))] for share in shares)


def control_line(control: PhysicalControl) -> str:
    """The layout's line for this control."""
    name = (control.role or control.usage).replace(" ", "-")
    which = (
        f"role={quoteattr(control.role)}" if control.role else f"usage={quoteattr(control.usage)}"
    )
    return f'  <control name={quoteattr(name)} type="{control.kind.value}" {which}/>'


def joystick_line(device: DeviceInfo) -> str:
    """The layout's line for this kind of device."""
    return f'<joystick name="pad" vid="{device.vid:04x}" pid="{device.pid:04x}">'


class TestedDevices:
    """All joysticks of this machine, with their reports.

    Attributes:
        tested: The joysticks, by their paths.
        listed: Whether the system has listed any device so far.
    """

    def __init__(self, reader: DeviceReader, joysticks: Sequence[JoystickSpec] | None) -> None:
        self._joysticks = joysticks
        self._assigned: Mapping[str, DeviceInfo] = {}
        self.tested: dict[str, TestedDevice] = {}
        self.listed = False
        self._reader = reader
        self._store = CalibrationStore()
        self._mappings = Mappings()

    @property
    def trouble(self) -> str:
        """The fault in the user's own roles, in one sentence; else empty."""
        return self._mappings.fault

    def turn(self, now: float) -> None:
        """Take new reports."""
        for news in self._reader.news():
            self._learn(news)
        for path, one in self.tested.items():
            inbox = self._reader.inbox(path)
            if inbox is not None:
                one.take(inbox, now)

    def _learn(self, news: News) -> None:
        match news:
            case Scanned(devices=devices):
                self.listed = self.listed or bool(devices)
                here = {device.path: device for device in devices if device.joystick}
                for path in [each for each in self.tested if each not in here]:
                    self._reader.stop(path)
                    del self.tested[path]
                self._assigned = assigned(self._joysticks or (), devices, self._assigned)
                for path, device in here.items():
                    self.tested.setdefault(path, TestedDevice(device))
                    self._reader.read(device)
            case Opened(path=path, controls=controls) if path in self.tested:
                self._opened(self.tested[path], controls)
            case Refused(path=path) if path in self.tested:
                self._reader.stop(path)
                self.tested[path].why = news.why
                if news.forbidden:
                    self.tested[path].why += f"; {rule_advice(self.tested[path].device)}"
            case Gone(path=path) if path in self.tested:
                self._reader.stop(path)
                self.tested[path].why = "it is gone"

    def _opened(self, one: TestedDevice, controls: tuple[PhysicalControl, ...]) -> None:
        specs = [
            spec for spec in self._joysticks or () if self._assigned.get(spec.name) == one.device
        ]
        one.opened(
            self._mappings.applied(one.device, controls),
            self._store,
            next(iter(specs), None if self._joysticks is None else _NOT_IN_LAYOUT),
        )


class _Pictures:
    """Draws the whole terminal repeatedly."""

    def begin(self) -> None:
        sys.stdout.write(_ENTER)

    def show(self, devices: TestedDevices) -> None:
        columns, rows = shutil.get_terminal_size()
        lines = [line for one in devices.tested.values() for line in lines_of(one)]
        lines += [devices.trouble] if devices.trouble else []
        lines = lines or [f"{_NOTHING if devices.listed else absence()}; waiting for one"]
        folded = [row for line in lines for row in fold(line, columns)]
        shown = [*folded[: max(0, rows - 2)], "", "ctrl+c ends this"]
        whole = "\n".join(f"{row[:columns]}{_REST_OF_LINE}" for row in shown)
        sys.stdout.write(f"{_HOME}{whole}{_BELOW}")
        sys.stdout.flush()

    def end(self) -> None:
        sys.stdout.write(_LEAVE)
        sys.stdout.flush()


class _Lines:
    """Writes a line for each control at its first move."""

    def __init__(self) -> None:
        self._reported: set[tuple[str, int]] = set()
        self._device = ""

    def begin(self) -> None:
        sys.stderr.write("move each control as far as it goes; ctrl+c ends this\n")

    def show(self, devices: TestedDevices) -> None:
        for path, one in devices.tested.items():
            for position, control in enumerate(one.controls):
                if one.moved(position) and (path, position) not in self._reported:
                    self._reported.add((path, position))
                    self._report(one.device, control)

    def _report(self, device: DeviceInfo, control: PhysicalControl) -> None:
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


def _follow(output: _Pictures | _Lines, joysticks: Sequence[JoystickSpec] | None = None) -> None:
    moved = threading.Event()
    reader = local_devices.reader()
    devices = TestedDevices(reader, joysticks)
    reader.start(moved.set)
    output.begin()
    try:
        while True:
            moved.wait(_RATE_S)
            moved.clear()
            devices.turn(time.monotonic())
            output.show(devices)
            time.sleep(_FRAME_S)
    finally:
        output.end()
        reader.close()
