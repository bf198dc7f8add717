"""Rules for joysticks of a layout: distinct devices, controls that exist and fit."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from rune_tui.layout import names
from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted, tag
from rune_tui.layout.joysticks import KINDS_FOR, JoystickNodes
from rune_tui.layout.places import Place
from rune_tui.layout.rules import HandlerRule
from rune_tui.layout.spec import ControlKind

_WHICH = ("role", "usage", "index")
_OF_DEVICE = ("vid", "pid", "serial", "device")
_OF_AXES = ("calibrate", "min", "max", "deadzone", "expo")
_NUMBERED = re.compile(r"#([2-9]|[1-9][0-9]{1,2})$")
"""The end of the usage of the second and further controls of the same name."""
_ARTICLES = {
    ControlKind.AXIS: "an axis",
    ControlKind.BALL: "a ball",
    ControlKind.BUTTON: "a button",
    ControlKind.HAT: "a hat switch",
}


def joystick_mistakes(nodes: Iterable[Node], rules: Rules) -> Iterator[Mistake]:
    """The mistakes in joysticks; another check finds equal names."""
    of_any: Place | None = None
    for node in nodes:
        if "pid" in node.attributes and "vid" not in node.attributes:
            message = "a pid counts only together with the vid of its vendor, add that"
            yield Mistake(node.at("pid"), message)
        if not any(attribute in node.attributes for attribute in _OF_DEVICE):
            if of_any is not None:
                message = (
                    f"this joystick is any device, as is that in {of_any.seen_from(node.place)}"
                )
                yield Mistake(node.place, f"{message}; give one of them vid, pid, serial or device")
            of_any = of_any or node.place
        for control in node.of("control"):
            yield from _control_mistakes(control, rules)


def _control_mistakes(control: Node, rules: Rules) -> Iterator[Mistake]:
    given = [attribute for attribute in _WHICH if attribute in control.attributes]
    if len(given) != 1:
        said = "does not say which it is" if not given else f"says so by {' and by '.join(given)}"
        message = f"{tag('control')} {said}: give it one of role, usage and index"
        yield Mistake(control.at(given[1]) if given else control.place, message)
    text = rules.value(control, "type")
    kind = ControlKind(text) if text else None
    role = rules.value(control, "role")
    if role is not None and role not in names.ROLES:
        yield Mistake(control.at("role"), f"unknown role {quoted(role)}{hint(role, names.ROLES)}")
    elif role is not None and kind is not None and not _has_role(kind, role):
        message = f"the role {role} is that of {_ARTICLES[names.ROLES[role]]}; write "
        yield Mistake(control.at("type"), f'{message}type="{names.ROLES[role].value}"')
    yield from _usage_mistakes(control, kind, rules)
    yield from _out_of_kind(control, kind, text)
    yield from _range_mistakes(control, rules)
    for bindings in control.of("hatSwitchBindings"):
        yield from _binding_mistakes(bindings, rules)


def _has_role(kind: ControlKind, role: str) -> bool:
    return kind is names.ROLES[role] or (kind is ControlKind.BUTTON and role in names.TRIGGERS)


def _usage_mistakes(control: Node, kind: ControlKind | None, rules: Rules) -> Iterator[Mistake]:
    """Report a control that no device has; names of buttons are not all known."""
    usage = rules.value(control, "usage")
    if usage is None or kind in {None, ControlKind.BUTTON}:
        return
    known = (names.HAT_USAGE,) if kind is ControlKind.HAT else names.AXIS_USAGES
    if _NUMBERED.sub("", usage) not in known:
        message = f"unknown usage {quoted(usage)} of {_ARTICLES[kind]}{hint(usage, known)}"
        yield Mistake(control.at("usage"), message)


def _out_of_kind(control: Node, kind: ControlKind | None, text: str | None) -> Iterator[Mistake]:
    if kind not in {None, ControlKind.AXIS}:
        for attribute in _OF_AXES:
            if attribute in control.attributes:
                message = f"{attribute} is for axes, leave it out of a control of type {text}"
                yield Mistake(control.at(attribute), message)
    if kind is ControlKind.HAT and "invert" in control.attributes:
        message = "a hat switch cannot be inverted, exchange its bindings instead"
        yield Mistake(control.at("invert"), message)
    if kind not in {None, ControlKind.HAT}:
        for bindings in control.of("hatSwitchBindings"):
            message = f"{tag(bindings.tag)} is for hat switches, not for a control of type {text}"
            yield Mistake(bindings.place, message)


def _range_mistakes(control: Node, rules: Rules) -> Iterator[Mistake]:
    least, most = rules.value(control, "min"), rules.value(control, "max")
    if least is not None and most is not None and int(least) >= int(most):
        message = f"min is {least} and max is {most}, min must be less; invert exchanges directions"
        yield Mistake(control.at("min"), message)


def _binding_mistakes(bindings: Node, rules: Rules) -> Iterator[Mistake]:
    first: dict[int, str] = {}
    for direction in names.DIRECTIONS:
        text = rules.value(bindings, direction)
        if text is not None:
            known = first.setdefault(int(text), direction)
            if known != direction:
                message = f"{direction} and {known} of {tag(bindings.tag)} are both {text}"
                yield Mistake(bindings.at(direction), f"{message}; a hat tells them apart")


def event_mistakes(event: Node, rules: Rules, joysticks: JoystickNodes) -> Iterator[Mistake]:
    """The mistakes in an event's joystick, if it has one."""
    parts = [part for part in KINDS_FOR if part in event.attributes]
    if "direction" in event.attributes and "hat" not in event.attributes:
        yield Mistake(event.at("direction"), "a direction belongs to a hat, leave it out")
    if "joystick" not in event.attributes:
        for part in parts:
            message = f"{part} is of a joystick, add the attribute joystick"
            yield Mistake(event.at(part), f"{message}{hint('', joysticks.names)}")
        return
    joystick = rules.value(event, "joystick")
    if joystick is not None and joystick not in joysticks.names:
        near = hint(joystick, joysticks.names) or f'; add <joystick name="{joystick}"/>'
        yield Mistake(event.at("joystick"), f"unknown joystick {quoted(joystick)}{near}")
    if len(parts) != 1:
        what = "needs one" if not parts else "has one alone"
        message = f"an event of a joystick {what} of the attributes {', '.join(KINDS_FOR)}"
        yield Mistake(event.at(parts[1]) if parts else event.place, message)
        return
    (part,) = parts
    if part in {"axis", "ball"} and "when" in event.attributes:
        instead = "; to press an axis, write button=" if part == "axis" else ""
        message = f"{part} events are neither pressed nor released, leave when out{instead}"
        yield Mistake(event.at("when"), message)
    if joystick in joysticks.names:
        yield from _named_control_mistakes(event, part, joystick, rules, joysticks)


def _named_control_mistakes(
    event: Node, part: str, joystick: str, rules: Rules, joysticks: JoystickNodes
) -> Iterator[Mistake]:
    control, known = rules.value(event, part), joysticks.kinds(joystick)
    if control is None or known.get(control, ControlKind.AXIS) is None:
        return
    kind = known.get(control)
    if kind is None:
        fitting = [name for name, kind in known.items() if kind in (None, *KINDS_FOR[part])]
        near = hint(control, fitting) or f"; describe it in {tag('joystick')}"
        message = f"unknown {part} {quoted(control)} of joystick {quoted(joystick)}{near}"
        yield Mistake(event.at(part), message)
    elif kind not in KINDS_FOR[part]:
        right = next(each for each, kinds in KINDS_FOR.items() if kinds[0] is kind)
        message = f"{quoted(control)} of joystick {quoted(joystick)} is {_ARTICLES[kind]}"
        yield Mistake(event.at(part), f'{message}; write {right}="{control}"')


def handler_mistakes(
    event: Node, handler: str, rule: HandlerRule, rules: Rules, joysticks: JoystickNodes
) -> Iterator[Mistake]:
    """That a handler can do nothing with the input of an event."""
    if "joystick" not in event.attributes:
        if rule.held and rules.value(event, "mouse") in {"wheel", "motion"}:
            message = f"{handler} acts while an input is held, which the mouse's"
            yield Mistake(event.at("mouse"), f"{message} {event.attributes['mouse']} never is")
        return
    inputs = joysticks.inputs(event)
    kinds = {each.kind for each in inputs}
    if rule.pointed:
        message = f"{handler} has to know where, give its event a mouse button, not a joystick"
        yield Mistake(event.at("joystick"), message)
    elif kinds & {ControlKind.AXIS, ControlKind.BALL} and not rule.words:
        message = f"{handler} knows no more and less, so that an axis or a ball says nothing to it"
        yield Mistake(event.at("axis" if "axis" in event.attributes else "ball"), message)
    elif ControlKind.BALL in kinds and rule.held:
        message = f"{handler} acts while an input is held, which a ball never is"
        yield Mistake(event.at("ball"), message)
    elif ControlKind.AXIS in kinds and _one_way(event, rule, rules):
        control = event.attributes["control"]
        message = f"the control {control} of {handler} is on or off, write button= and not axis="
        yield Mistake(event.at("axis"), message)
    if any(each.pushed for each in inputs):
        yield from _whole_hat_mistakes(event, handler, rule)


def _one_way(event: Node, rule: HandlerRule, rules: Rules) -> bool:
    """Whether the control of an event can be moved in no direction."""
    control = rules.value(event, "control") or ""
    return control in rule.controls and control not in rule.words


def _whole_hat_mistakes(event: Node, handler: str, rule: HandlerRule) -> Iterator[Mistake]:
    if rule.plane is None:
        message = f"{handler} is moved one way by each direction of a hat, add direction"
        yield Mistake(event.at("hat"), f"{message}{hint('', names.DIRECTIONS)}")
    elif "control" in event.attributes:
        moved = " and ".join(rule.plane)
        message = f"a hat without direction moves {moved}, leave control out or add direction"
        yield Mistake(event.at("control"), message)
