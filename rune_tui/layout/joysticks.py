"""The joysticks of a layout file: their controls, and the inputs of events."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from hub.values import dataclass
from rune_tui.layout import names
from rune_tui.layout.grammar import Node, Rules
from rune_tui.layout.spec import ControlKind, ControlSpec, JoystickSpec

KINDS_FOR: Mapping[str, tuple[ControlKind, ...]] = {
    "axis": (ControlKind.AXIS,),
    "button": (ControlKind.BUTTON, ControlKind.AXIS),
    "hat": (ControlKind.HAT,),
    "ball": (ControlKind.BALL,),
}
"""The kinds of controls that each attribute of an event may name; an axis can act as a button."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Input:
    """An input that an event waits for.

    Attributes:
        name: Its name in `ControlEvent`.
        kind: Its kind of control; None for keys and the mouse.
        pushed: Where a hat is pushed, if the event means all four of its directions.
    """

    name: str
    kind: ControlKind | None = None
    pushed: str = ""


class JoystickNodes:
    """The joysticks of a layout by name; of two of one name, the first."""

    def __init__(self, nodes: Iterable[Node], rules: Rules) -> None:
        self._rules = rules
        self._nodes: dict[str, Node] = {}
        for node in nodes:
            if name := rules.value(node, "name"):
                self._nodes.setdefault(name, node)

    @property
    def names(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self._nodes)

    def kinds(self, joystick: str) -> dict[str, ControlKind | None]:
        """The names of a joystick for events: its controls, and roles of possible controls.

        A control whose type breaks its rule has the kind None.
        """
        found: dict[str, ControlKind | None] = {}
        for node in self._nodes[joystick].of("control"):
            kind, name = self._rules.value(node, "type"), self._rules.value(node, "name")
            if name:
                found.setdefault(name, ControlKind(kind) if kind else None)
        return found | {role: kind for role, kind in names.ROLES.items() if role not in found}

    def inputs(self, event: Node) -> tuple[Input, ...]:
        """The inputs of a joystick that an event waits for; none: it is wrong."""
        parts = [part for part in KINDS_FOR if part in event.attributes]
        joystick = self._rules.value(event, "joystick")
        if joystick not in self._nodes or len(parts) != 1:
            return ()
        control = self._rules.value(event, parts[0]) or ""
        kind = self.kinds(joystick).get(control)
        if kind not in KINDS_FOR[parts[0]]:
            return ()
        if kind is ControlKind.HAT:
            return tuple(self._pushed(event, joystick, control))
        pressed = parts == ["button"] and kind is ControlKind.AXIS
        part, kind = (names.PRESSED, ControlKind.BUTTON) if pressed else ("", kind)
        return (Input(name=names.joystick_input(joystick, control, part), kind=kind),)

    def _pushed(self, event: Node, joystick: str, control: str) -> Iterator[Input]:
        alone = "direction" in event.attributes
        direction = self._rules.value(event, "direction")
        for pushed in (direction,) if alone else names.DIRECTIONS:
            if pushed is not None:
                name = names.joystick_input(joystick, control, pushed)
                yield Input(name=name, kind=ControlKind.HAT, pushed="" if alone else pushed)

    def specs(self, events: Iterable[Node]) -> tuple[JoystickSpec, ...]:
        """The joysticks of a faultless layout, which has these events."""
        used: dict[str, dict[str, None]] = {name: {} for name in self._nodes}
        for event in events:
            if joystick := self._rules.value(event, "joystick"):
                (part,) = (part for part in KINDS_FOR if part in event.attributes)
                used[joystick][self._rules.value(event, part) or ""] = None
        return tuple(self._spec(name, node, used[name]) for name, node in self._nodes.items())

    def _spec(self, name: str, node: Node, used: Iterable[str]) -> JoystickSpec:
        described = tuple(map(self._control, node.of("control")))
        others = dict.fromkeys(used).keys() - {control.name for control in described}
        implied = (
            ControlSpec(name=role, kind=names.ROLES[role], role=role)
            for role in used
            if role in others
        )
        vid, pid = (self._rules.value(node, which) for which in ("vid", "pid"))
        return JoystickSpec(
            name=name,
            vid=None if vid is None else int(vid, 16),
            pid=None if pid is None else int(pid, 16),
            serial=self._rules.value(node, "serial") or "",
            device=self._rules.value(node, "device") or "",
            controls=(*described, *implied),
        )

    def _control(self, node: Node) -> ControlSpec:
        def text(attribute: str) -> str:
            return self._rules.value(node, attribute) or ""

        def whole(attribute: str, of: Node = node) -> int | None:
            found = self._rules.value(of, attribute)
            return None if found is None else int(found)

        def share(attribute: str) -> float | None:
            return float(found) if (found := text(attribute)) else None

        bindings = [
            (up, right, down, left)
            for child in node.of("hatSwitchBindings")
            for up, right, down, left in [[whole(each, child) or 0 for each in names.DIRECTIONS]]
        ]
        return ControlSpec(
            name=text("name"),
            kind=ControlKind(text("type")),
            role=text("role"),
            usage=text("usage"),
            index=whole("index"),
            calibrate=text("calibrate") == "true",
            minimum=whole("min"),
            maximum=whole("max"),
            invert=text("invert") == "true",
            deadzone=share("deadzone"),
            expo=share("expo"),
            bindings=bindings[0] if bindings else None,
        )
