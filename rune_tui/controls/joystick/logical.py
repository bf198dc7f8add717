"""A joystick of the layout at work: reports of its device in, control events out; pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from hub.values import dataclass
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.hid.device_controls import PhysicalControl, hat_direction
from rune_tui.controls.joystick.axes import Axis
from rune_tui.controls.joystick.calibration import Calibration, GuidedAxis
from rune_tui.layout.names import DIRECTIONS, ONE_SIDED, PRESSED, joystick_input
from rune_tui.layout.spec import ControlKind, ControlSpec, JoystickSpec

_PRESSED_AT, _RELEASED_AT = 0.5, 0.4
"""Shares from which on an axis counts as a pressed button, and below which it no longer does."""
_LEVER_PRESSED_AT, _LEVER_RELEASED_AT = 0.12, 0.08
_PAIRS = {"leftx": "lefty", "rightx": "righty"}
_STEPS = 1000
"""Step of the values of axes, so that noise in the last bit is no event."""
_DPAD = "dpad"
_CROSS = ("dpup", "dpright", "dpdown", "dpleft")
"""Roles of a cross of buttons, in the order of `DIRECTIONS`."""

Values = Sequence[tuple[int, int | None]]
"""Positions of a device's controls and their raw values; None: no value."""


@dataclass(frozen=True, slots=True)
class _Part:
    """The source of a control of the layout, or of one direction of it.

    Attributes:
        name: The input's name.
        shown: Its name among the joystick's values.
        spec: Its element in the layout.
        position: The control of the device.
        direction: For a hat: one of `DIRECTIONS`.
    """

    name: str
    shown: str
    spec: ControlSpec
    position: int
    direction: int = 0


class LogicalJoystick:
    """Follows one device for one joystick of the layout; the clock is passed in.

    | control | counts |
    | --- | --- |
    | deflected when the device appears, or when all input is released | after it was neutral |
    | a button | from its first press, because many devices report nothing before it |

    Attributes:
        spec: Its element in the layout.
        values: The position of each control, -1 to 1, if it is known.
    """

    def __init__(self, spec: JoystickSpec) -> None:
        self.spec = spec
        self.values: dict[str, float] = {}
        self._controls: Sequence[PhysicalControl] = ()
        self._axes: dict[str, Axis] = {}
        self._at: dict[int, list[Axis]] = {}
        self._partners: dict[str, Axis] = {}
        """The other axis of the stick of each axis, if the two share a dead zone."""
        self._inputs: dict[str, tuple[str, str]] = {}
        """The names of each axis's inputs: its value, and its press."""
        self._parts: dict[int, list[_Part]] = {}
        self._out: dict[str, float] = {}
        self._blocked: set[str] = set()

    def connect(
        self,
        controls: Sequence[PhysicalControl],
        calibrations: Mapping[str, Calibration],
    ) -> tuple[str, ...]:
        """Take a device.

        Args:
            controls: Its controls.
            calibrations: Calibrations of its axes, by usage.

        Returns:
            Names of the layout's controls that it does not have.
        """
        self._forget_device()
        self._controls = controls
        missing = []
        for spec in self.spec.controls:
            found = (
                self._add_axis(spec, calibrations)
                if spec.kind is ControlKind.AXIS
                else self._add_parts(spec)
            )
            if not found:
                missing.append(spec.name)
        for axis in self._axes.values():
            if (partner := self._partner_of(axis)) is not None:
                self._partners[axis.name] = partner
        return tuple(missing)

    def feed(self, values: Values, now: float) -> tuple[ControlEvent, ...]:
        """Take values of the device; returns the events, buttons first, in their order."""
        events: list[ControlEvent] = []
        moved: dict[str, Axis] = {}
        for position, raw in values:
            if not 0 <= position < len(self._controls):
                continue
            for axis in self._at.get(position, ()):
                if raw is not None:
                    axis.take(raw, now)
                    moved[axis.name] = axis
                    if (partner := self._partner(axis)) is not None:
                        moved[partner.name] = partner
            for part in self._parts.get(position, ()):
                events += self._moved_part(part, raw)
        for axis in moved.values():
            events += self._moved_axis(axis)
        return tuple(events)

    def lost(self) -> tuple[ControlEvent, ...]:
        """Release everything, because the device is gone."""
        released = self.release_all()
        self._forget_device()
        return released

    def release_all(self) -> tuple[ControlEvent, ...]:
        """Release everything; a deflected control counts again after it was neutral."""
        released = tuple(ControlEvent(name=name, pressed=False, value=0.0) for name in self._out)
        self._blocked |= self._out.keys()
        self._out.clear()
        return released

    @property
    def axis_inputs(self) -> frozenset[str]:
        """Names of the inputs that are axes."""
        return frozenset(value for value, _ in self._inputs.values())

    @property
    def waiting(self) -> frozenset[str]:
        """Names of the axes that are moved and count only after they have been neutral."""
        return frozenset(
            name
            for name, (value, _) in self._inputs.items()
            if value in self._blocked and self.values.get(name)
        )

    @property
    def axes(self) -> Mapping[str, Axis]:
        """Those that the device has, by the layout's names."""
        return self._axes

    def shown_at(self, position: int) -> tuple[str, ...]:
        """Names in `values` of the controls that a control of the device feeds."""
        axes = tuple(axis.name for axis in self._at.get(position, ()))
        return axes + tuple(part.shown for part in self._parts.get(position, ()))

    def raws(self) -> Mapping[str, int | None]:
        """The present values of the axes [device units], by usage."""
        return {axis.physical.usage: axis.raw for axis in self._axes.values()}

    def to_calibrate(self, control: str = "") -> tuple[GuidedAxis, ...]:
        """Axes that the operator can calibrate.

        Args:
            control: Name of one of them; empty for those of `calibrate`, or all if there are none.
        """
        wanted = [axis for axis in self._axes.values() if control in {"", axis.name}]
        if not control:
            marked = {spec.name for spec in self.spec.controls if spec.calibrate}
            wanted = [axis for axis in wanted if axis.name in marked] or wanted
        return tuple(
            GuidedAxis(
                control=axis.name,
                usage=axis.physical.usage,
                lever=axis.lever,
                width=axis.physical.maximum - axis.physical.minimum,
            )
            for axis in wanted
        )

    def _forget_device(self) -> None:
        self._controls = ()
        self._axes.clear()
        self._at.clear()
        self._partners.clear()
        self._inputs.clear()
        self._parts.clear()
        self.values = {}

    def _add_axis(self, spec: ControlSpec, calibrations: Mapping[str, Calibration]) -> bool:
        position = self._find(spec)
        if position is None:
            return False
        physical = self._controls[position]
        axis = Axis.of(spec, physical, calibrations.get(physical.usage))
        self._axes[spec.name] = axis
        self._at.setdefault(position, []).append(axis)
        # A hand may hold it anywhere: it must be seen at rest first.
        inputs = self._input(spec.name), self._input(spec.name, PRESSED)
        self._inputs[spec.name] = inputs
        self._blocked.update(inputs)
        return True

    def _add_parts(self, spec: ControlSpec) -> bool:
        parts = list(self._parts_of(spec))
        for part in parts:
            self._parts.setdefault(part.position, []).append(part)
        return bool(parts)

    def _parts_of(self, spec: ControlSpec) -> Iterator[_Part]:
        """The source of a button, ball or hat; a cross of buttons is a hat as well."""
        position = self._find(spec)
        if spec.kind is not ControlKind.HAT:
            if position is not None:
                yield _Part(self._input(spec.name), spec.name, spec, position)
            elif (
                spec.role in _CROSS and (hat := self._with_role(_DPAD, ControlKind.HAT)) is not None
            ):
                direction = _CROSS.index(spec.role)
                yield _Part(self._input(spec.name), spec.name, spec, hat, direction)
            return
        for direction, word in enumerate(DIRECTIONS):
            source = position
            if position is None and spec.role == _DPAD:
                source = self._with_role(_CROSS[direction], ControlKind.BUTTON)
            if source is not None:
                name = self._input(spec.name, word)
                yield _Part(name, f"{spec.name} {word}", spec, source, direction)

    def _find(self, spec: ControlSpec) -> int | None:
        """The control of the device that the layout means; a trigger may be a mere button."""
        kinds = (spec.kind, ControlKind.BUTTON) if spec.role in ONE_SIDED else (spec.kind,)
        for kind in kinds:
            for position, control in enumerate(self._controls):
                if control.kind is kind and _is_meant(control, spec):
                    return position
        return None

    def _with_role(self, role: str, kind: ControlKind) -> int | None:
        return next(
            (
                position
                for position, control in enumerate(self._controls)
                if control.role == role and control.kind is kind
            ),
            None,
        )

    def _input(self, control: str, part: str = "") -> str:
        return joystick_input(self.spec.name, control, part)

    def _moved_part(self, part: _Part, raw: int | None) -> Iterator[ControlEvent]:
        control = self._controls[part.position]
        if control.kind is ControlKind.BALL:
            counts = float(raw or 0)
            counts = -counts if part.spec.invert != control.flipped else counts
            self.values[part.shown] = max(-1.0, min(1.0, counts / max(1, control.maximum)))
            if counts:
                yield ControlEvent(name=part.name, pressed=True, value=counts)
            return
        if control.kind is ControlKind.HAT:
            x, y = hat_direction(raw, control, part.spec.bindings)
            down = (y > 0, x > 0, y < 0, x < 0)[part.direction]
        else:
            down = bool(raw) != part.spec.invert
        self.values[part.shown] = float(down)
        yield from self._put(part.name, float(down))

    def _partner_of(self, axis: Axis) -> Axis | None:
        """The other axis of its stick, if the two share a dead zone."""
        role = axis.physical.role
        other = _PAIRS.get(role) or next((x for x, y in _PAIRS.items() if y == role), None)
        for each in self._axes.values():
            if other and each.physical.role == other:
                return each if each.shape.dead_zone == axis.shape.dead_zone else None
        return None

    def _partner(self, axis: Axis) -> Axis | None:
        """That axis, once it has a value."""
        partner = self._partners.get(axis.name)
        return None if partner is None or partner.raw is None else partner

    def _moved_axis(self, axis: Axis) -> Iterator[ControlEvent]:
        partner, share = self._partner(axis), axis.share
        if partner is None:
            value = axis.shape.shaped(share)
        else:
            value = axis.shape.shaped_pair(share, partner.share)[0]
        value = round(value * _STEPS) / _STEPS
        self.values[axis.name] = value
        moved, name = self._inputs[axis.name]
        yield from self._put(moved, value)
        at = (_LEVER_PRESSED_AT, _LEVER_RELEASED_AT) if axis.lever else (_PRESSED_AT, _RELEASED_AT)
        down = abs(share) > at[name in self._out or name in self._blocked]
        yield from self._put(name, float(down))

    def _put(self, name: str, value: float) -> Iterator[ControlEvent]:
        """An input is at a value now, 0 for neutral."""
        if name in self._blocked:
            if not value:
                self._blocked.discard(name)
            return
        before = self._out.get(name, 0.0)
        if value == before:
            return
        if value:
            self._out[name] = value
        else:
            del self._out[name]
        repeat = value != 0.0 and before != 0.0
        yield ControlEvent(name=name, pressed=value != 0.0, repeat=repeat, value=value)


def _is_meant(control: PhysicalControl, spec: ControlSpec) -> bool:
    """Whether a control of the device is the one that the layout means."""
    if spec.role:
        # Buttons with names have numbers too.
        return control.role == spec.role or control.usage.replace(" ", "") == spec.role
    if spec.usage:
        return control.usage == spec.usage
    return control.index == (spec.index or 0)
