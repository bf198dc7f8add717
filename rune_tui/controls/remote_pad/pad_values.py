"""A device's controls as one row of numbers, so that the newest row is complete; pure.

A lost row must not lose an edge of a button or a turn of a ball, so a row has counts of these.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from hub.gcm.pad import NO_VALUE
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.hid.reading import Value
from rune_tui.layout.spec import ControlKind

_LARGEST = (1 << 31) - 1
_EDGES = 1 << 31
_TURNS = 1 << 32
_MOST_EDGES = 2
"""Largest number of edges taken from one row; the final state is always taken."""


class Row:
    """The numbers of one device, kept up to date.

    Attributes:
        values: One for each control, as `hub.gcm.pad.PadState` has them.
    """

    def __init__(self, controls: Sequence[PhysicalControl]) -> None:
        self._kinds = [control.kind for control in controls]
        self.values = [_nothing(kind) for kind in self._kinds]

    def take(self, values: Iterable[Value]) -> bool:
        """Take reports of the device; whether a value changed."""
        changed = [self._follow(position, raw) for position, raw in values]
        return True in changed

    def _follow(self, position: int, raw: int | None) -> bool:
        before = self.values[position]
        match self._kinds[position]:
            case ControlKind.BUTTON:
                now = (before + (bool(raw) != bool(before & 1))) % _EDGES
            case ControlKind.BALL:
                now = _wrapped(before + (raw or 0))
            case _:
                now = NO_VALUE if raw is None else max(-_LARGEST, min(_LARGEST, raw))
        self.values[position] = now
        return now != before


def reports(
    controls: Sequence[PhysicalControl], before: Sequence[int] | None, now: Sequence[int]
) -> Iterator[tuple[Value, ...]]:
    """The values that a device reported between two rows.

    Args:
        controls: Its controls, one for each number.
        before: The row before; None if this is the first.
        now: The row; any numbers are one.
    """
    whole: list[Value] = []
    for position, control in enumerate(controls):
        value, last = now[position], None if before is None else before[position]
        if control.kind is ControlKind.BUTTON:
            down = value & 1
            edges = 0 if last is None else (value - last) % _EDGES
            for left in reversed(range(1, min(edges, _MOST_EDGES + edges % 2))):
                yield ((position, down ^ left & 1),)
            whole.append((position, down))
        elif control.kind is ControlKind.BALL:
            turned = 0 if last is None else _wrapped(value - last)
            whole.append((position, turned))
        else:
            whole.append((position, None if value == NO_VALUE else value))
    yield tuple(whole)


def _nothing(kind: ControlKind) -> int:
    return 0 if kind in (ControlKind.BUTTON, ControlKind.BALL) else NO_VALUE


def _wrapped(turns: int) -> int:
    return (turns + _TURNS // 2) % _TURNS - _TURNS // 2
