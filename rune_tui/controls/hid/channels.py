"""The controls of a joystick by its descriptor: their places and names."""

from __future__ import annotations

from collections import Counter

from hub.values import dataclass
from rune_tui.controls.hid import usages
from rune_tui.controls.hid.descriptor import InputField, ReportDescriptor
from rune_tui.errors import DescriptorError
from rune_tui.layout.spec import ControlKind

MAX_CONTROLS = 512
"""Most controls of one device; real ones have up to about 140."""
MAX_ELEMENTS = 4096
"""Most elements that are checked for controls."""
MAX_SIZE = 32
"""Longest value of a control [bits]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """A control in the report that holds it.

    Attributes:
        kind: Its kind.
        name: Its usage as layouts write it; "#2" for the second of the same.
        field: The field that holds it.
        bit: Where its element begins, after the byte of the report id [bits]; in an array the
            first element.
        value: In an array, the elements' value while it is on; else None.
        minimum: Least value that means something.
        maximum: Greatest one.
    """

    kind: ControlKind
    name: str
    field: InputField
    bit: int
    value: int | None
    minimum: int
    maximum: int


def find_channels(descriptor: ReportDescriptor) -> tuple[Channel, ...]:
    """All controls of a joystick's, gamepad's or multi-axis controller's collections.

    Raises:
        DescriptorError: It describes more than any real device has.
    """
    channels: list[Channel] = []
    seen: Counter[str] = Counter()
    elements = 0
    for field in descriptor.fields:
        if not _may_hold_controls(field):
            continue
        elements += field.count
        for place, usage in enumerate(field.usages_of_elements()):
            elements += field.array
            if elements > MAX_ELEMENTS:
                message = f"a joystick's descriptor with more than {MAX_ELEMENTS} elements"
                raise DescriptorError(message)
            kind, name = _meaning(field, usage)
            if not name:
                continue
            if len(channels) == MAX_CONTROLS:
                message = f"a joystick's descriptor with more than {MAX_CONTROLS} controls"
                raise DescriptorError(message)
            seen[name] += 1
            number = f"#{seen[name]}" if seen[name] > 1 else ""
            minimum, maximum = (0, 1) if field.array else _limits(field)
            channels.append(
                Channel(
                    kind=kind,
                    name=name + number,
                    field=field,
                    bit=field.bit if field.array else field.bit + place * field.size,
                    value=field.minimum + place if field.array else None,
                    minimum=minimum,
                    maximum=maximum,
                )
            )
    return tuple(channels)


def _may_hold_controls(field: InputField) -> bool:
    return (
        field.application in usages.JOYSTICKS
        and 0 < field.size <= MAX_SIZE
        and field.usages[0][0] >> 16 < usages.FIRST_VENDOR
    )


def _limits(field: InputField) -> tuple[int, int]:
    """The range of values; all possible values if the descriptor's is empty."""
    if field.minimum < field.maximum:
        return field.minimum, field.maximum
    half = 1 << (field.size - 1)
    return (-half, half - 1) if field.minimum < 0 else (0, 2 * half - 1)


def _meaning(field: InputField, usage: int) -> tuple[ControlKind, str]:
    """Kind and name; an empty name if it is no control."""
    if field.array:
        return ControlKind.BUTTON, usages.switch_name(usage)
    if usage == usages.HAT or (usage == usages.UNNAMED and _turns(field)):
        return ControlKind.HAT, "hat switch"
    if usage in usages.AXES:
        # The first SpaceNavigators call deflections changes.
        is_ball = field.relative and field.application != usages.MULTI_AXIS
        return ControlKind.BALL if is_ball else ControlKind.AXIS, usages.AXES[usage]
    is_switch = field.maximum - field.minimum == 1 or usage >> 16 == usages.BUTTON
    return ControlKind.BUTTON, usages.switch_name(usage) if is_switch else ""


def _turns(field: InputField) -> bool:
    """Whether the values may be the eight directions of a hat."""
    return field.size == 4 and field.maximum - field.minimum == 7
