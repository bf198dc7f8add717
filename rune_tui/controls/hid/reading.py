"""How values are taken out of reports: worked out once for each kind of report."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

from hub.values import dataclass
from rune_tui.controls.hid.channels import Channel
from rune_tui.layout.spec import ControlKind

Value = tuple[int, int | None]
"""A control's position and its raw value; None while it has none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportSlot:
    """Where the value of one control is, and how it is read.

    Attributes:
        position: The control's position among those of the device.
        bit: Where the value begins, after the byte of the report id [bits].
        size: Its length [bits].
        signed: Whether it is a two's complement.
        limits: Values outside mean "no value".
        table: The replacement of each value.
    """

    position: int
    bit: int
    size: int
    signed: bool = False
    limits: tuple[int, int] | None = None
    table: tuple[int | None, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ArraySlot:
    """An array of elements that hold which of the controls are on.

    Attributes:
        bit: Where the first element begins, after the byte of the report id [bits].
        size: Length of an element [bits].
        count: How many elements.
        positions: Position of the control that each value of an element turns on.
        signed: Whether elements are two's complements.
    """

    bit: int
    size: int
    count: int
    positions: Mapping[int, int]
    signed: bool


class Reading:
    """The content of one kind of report."""

    def __init__(
        self,
        slots: Sequence[ReportSlot],
        arrays: Sequence[ArraySlot] = (),
        *,
        prefix: int,
        needed: tuple[int, int] = (0, 0),
    ) -> None:
        """Prepares everything.

        Args:
            slots: The controls with values of their own.
            arrays: The other fields.
            prefix: Bytes before the first bit.
            needed: Byte of the report, and mask: one of these bits has to be set, else the
                report holds nothing; no mask for any report.
        """
        self._all = slots, arrays
        self._prefix = prefix
        self._needed = needed
        first = prefix * 8
        self._plain, self._signed, self._limited, self._tabled = [], [], [], []
        for slot in slots:
            place = (slot.position, slot.bit + first, (1 << slot.size) - 1)
            half = 1 << (slot.size - 1) if slot.signed else 0
            if slot.table is not None:
                self._tabled.append((*place, slot.table))
            elif slot.limits is not None:
                self._limited.append((*place, half, *slot.limits))
            elif half:
                self._signed.append((*place, half))
            else:
                self._plain.append(place)
        self._arrays = [
            (
                [each.bit + first + place * each.size for place in range(each.count)],
                (1 << each.size) - 1,
                1 << (each.size - 1) if each.signed else 0,
                each.positions,
            )
            for each in arrays
        ]
        ends = [slot.bit + slot.size for slot in slots]
        ends += [each.bit + each.size * each.count for each in arrays]
        flags = needed[0] + 1 if needed[1] else 0
        self.length = max(flags, prefix + (max(ends, default=0) + 7) // 8)
        """Least length of a report that holds them all [bytes]."""

    def read(self, report: bytes) -> tuple[Value, ...] | None:
        """The values; None if it is too short for any of the controls that belong in it."""
        if len(report) < self.length:
            return self._read_short(report)
        place, mask = self._needed
        if mask and not report[place] & mask:
            return ()
        bits = int.from_bytes(report[: self.length], "little")
        values: list[Value] = [(which, bits >> at & mask) for which, at, mask in self._plain]
        for which, at, mask, half in self._signed:
            values.append((which, ((bits >> at & mask) ^ half) - half))
        for which, at, mask, table in self._tabled:
            values.append((which, table[bits >> at & mask]))
        for which, at, mask, half, least, most in self._limited:
            value = ((bits >> at & mask) ^ half) - half
            values.append((which, value if least <= value <= most else None))
        for places, mask, half, positions in self._arrays:
            on = {((bits >> at & mask) ^ half) - half for at in places}
            values += [(which, int(value in on)) for value, which in positions.items()]
        return tuple(values)

    def _read_short(self, report: bytes) -> tuple[Value, ...] | None:
        """Some devices leave out the end of a report, others send a short one first."""
        slots, arrays = self._all
        held = (len(report) - self._prefix) * 8
        there = Reading(
            [slot for slot in slots if slot.bit + slot.size <= held],
            [each for each in arrays if each.bit + each.size * each.count <= held],
            prefix=self._prefix,
        )
        if self._needed[1] or there.length == self._prefix:
            return None
        return there.read(report)


def read_as_described(channels: Sequence[Channel], *, numbered: bool) -> dict[int, Reading]:
    """The content of each report, by its id."""
    slots: defaultdict[int, list[ReportSlot]] = defaultdict(list)
    arrays: defaultdict[int, dict[int, tuple[Channel, dict[int, int]]]] = defaultdict(dict)
    for position, channel in enumerate(channels):
        field = channel.field
        if channel.value is not None:
            within = arrays[field.report_id].setdefault(field.bit, (channel, {}))
            within[1][channel.value] = position
        else:
            slots[field.report_id].append(_slot(position, channel))
    return {
        report_id: Reading(
            slots[report_id],
            [
                ArraySlot(
                    bit=bit,
                    size=channel.field.size,
                    count=channel.field.count,
                    positions=positions,
                    signed=channel.field.minimum < 0,
                )
                for bit, (channel, positions) in arrays[report_id].items()
            ],
            prefix=int(numbered),
        )
        for report_id in {*slots, *arrays}
    }


def _slot(position: int, channel: Channel) -> ReportSlot:
    field = channel.field
    limited = channel.kind is ControlKind.HAT or (
        field.nullable and channel.kind is not ControlKind.BUTTON
    )
    return ReportSlot(
        position=position,
        bit=channel.bit,
        size=field.size,
        signed=field.minimum < 0,
        limits=(channel.minimum, channel.maximum) if limited else None,
    )
