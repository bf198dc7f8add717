"""The controls of a joystick, and their values in its reports."""

from __future__ import annotations

from collections import Counter

from hub.values import dataclass
from rune_tui.controls.hid.channels import Channel, find_channels
from rune_tui.controls.hid.descriptor import parse
from rune_tui.controls.hid.reading import Value, read_as_described
from rune_tui.controls.hid.roles import find_roles
from rune_tui.controls.hid.usages import MULTI_AXIS
from rune_tui.controls.hid.vendor_reports import read_vendor_reports
from rune_tui.layout.spec import ControlKind

_FLIPPED_ROLES = frozenset({"lefty", "righty", "throttle"})
_DIRECTIONS = ((0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1))
"""Right and up, clockwise from up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PhysicalControl:
    """A control that a device has.

    Attributes:
        kind: Its kind.
        index: Which one of its kind, from 0.
        usage: Its name at the device, such as "x", "button 3", "hat switch"; "#2" at the end
            for the second of the same.
        role: Its role, such as "leftx"; empty: not known.
        minimum: Least raw value; for a ball of one report.
        maximum: Greatest raw value.
        flipped: Whether raw values grow down or towards the operator.
    """

    kind: ControlKind
    index: int
    usage: str
    role: str
    minimum: int
    maximum: int
    flipped: bool


class DeviceDecoder:
    """Decodes the reports of one device.

    Attributes:
        controls: All its controls, in the order of its descriptor.
        joystick: Whether it is a joystick: not a keyboard, a mouse, or a device without controls.
        descriptor: The report descriptor.
        unread: How many reports made no sense.
    """

    def __init__(self, descriptor: bytes, *, vid: int, pid: int, bus: int = 3) -> None:
        """Reads the descriptor.

        Args:
            descriptor: The report descriptor.
            vid: The maker's number.
            pid: The product's.
            bus: As Linux counts: 3 USB, 5 Bluetooth.

        Raises:
            DescriptorError: The descriptor cannot be read.
        """
        parsed = parse(descriptor)
        channels = find_channels(parsed)
        self._numbered = parsed.numbered
        self._known = frozenset(parsed.bits)
        self._readings = read_as_described(channels, numbered=parsed.numbered)
        self._readings |= read_vendor_reports(channels, vid=vid, pid=pid, bus=bus)
        self.controls = _controls(channels, find_roles(channels, vid=vid, pid=pid))
        self.joystick = bool(self.controls)
        self.descriptor = descriptor
        self.unread = 0

    def decode(self, report: bytes) -> tuple[Value, ...]:
        """Position in `controls` and raw value of each control that a report holds.

        The raw value is as the device says, None if it says that there is none, as a hat does in
        its centre. Never raises: a report that makes no sense holds nothing and is counted.
        """
        report_id = (report[0] if report else -1) if self._numbered else 0
        reading = self._readings.get(report_id)
        values = reading.read(report) if reading is not None else None
        if values is None:
            if reading is not None or report_id not in self._known:
                self.unread += 1
            return ()
        return values


def hat_direction(
    raw: int | None,
    control: PhysicalControl,
    bindings: tuple[int, int, int, int] | None = None,
) -> tuple[int, int]:
    """Where a hat points, right and up, each -1, 0 or 1.

    Args:
        raw: Its raw value.
        control: The hat.
        bindings: Raw values that mean up, right, down and left; None for those that are usual:
            the range is one turn clockwise from up.
    """
    if raw is None or not control.minimum <= raw <= control.maximum:
        return 0, 0
    span = control.maximum - control.minimum
    if bindings is not None:
        return _bound_direction(raw, bindings, span + 1)
    # Some count degrees, or hundredths of them, and the range ends with the last direction.
    turn = next((turn for turn in (360, 36000) if turn * 3 // 4 <= span <= turn), span + 1)
    return _DIRECTIONS[((raw - control.minimum) * 8 + turn // 2) // turn % 8]


def _bound_direction(raw: int, bindings: tuple[int, int, int, int], turn: int) -> tuple[int, int]:
    """As above; what lies between two neighbours is both."""
    if raw in bindings:
        return _DIRECTIONS[bindings.index(raw) * 2]
    for place, first in enumerate(bindings):
        second = bindings[(place + 1) % 4]
        there, back = (second - first) % turn, (first - second) % turn
        passed = (raw - first) % turn if there <= back else (raw - second) % turn
        if 0 < passed < min(there, back):
            return _DIRECTIONS[place * 2 + 1]
    return 0, 0


def _controls(channels: tuple[Channel, ...], roles: tuple[str, ...]) -> tuple[PhysicalControl, ...]:
    counts: Counter[ControlKind] = Counter()
    controls = []
    for channel, role in zip(channels, roles, strict=True):
        # Usages y, and z of six-axis controllers, grow towards the operator and down.
        down = {"y", "z"} if channel.field.application == MULTI_AXIS else {"y"}
        controls.append(
            PhysicalControl(
                kind=channel.kind,
                index=counts[channel.kind],
                usage=channel.name,
                role=role,
                minimum=channel.minimum,
                maximum=channel.maximum,
                flipped=channel.kind in (ControlKind.AXIS, ControlKind.BALL)
                and (channel.name.partition("#")[0] in down or role in _FLIPPED_ROLES),
            )
        )
        counts[channel.kind] += 1
    return tuple(controls)
