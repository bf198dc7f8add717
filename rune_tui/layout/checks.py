"""What a layout must keep beyond its schema: names that exist, keys that do not collide.

Values that break the schema are skipped here; the schema's own check has reported them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from hub.gcm.catalog import BY_NAME
from rune_tui.layout import names
from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted
from rune_tui.layout.inputs import TakenInputs, input_mistakes
from rune_tui.layout.references import reference_mistakes
from rune_tui.layout.rules import HandlerRule, NumberOption, Option, Vocabulary
from rune_tui.layout.spec import CHOSEN

_TCP = re.compile(r"tcp://([A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\]):([0-9]{1,5})")
_IPC = re.compile(r"ipc://[^\x00]+")
_LARGEST_PORT = 65535


def find_mistakes(root: Node, rules: Rules, vocabulary: Vocabulary) -> Iterator[Mistake]:
    """Everything wrong with a layout that its schema cannot say."""
    robots = root.of("robot")
    yield from _duplicates(robots, "robot", rules)
    for robot in robots:
        yield from _robot_mistakes(robot, rules)
    known = tuple(filter(None, (rules.value(robot, "name") for robot in robots)))
    inputs = TakenInputs(rules)
    viewports: list[Node] = []
    for view in root.of("view"):
        for child in view.children:
            if child.tag == "viewport":
                viewports.append(child)
                robot_name = viewport_robot(child, known, rules)
                yield from _viewport_mistakes(child, view, known, rules)
                for visualizer in child.of("visualizer"):
                    yield from _visualizer_mistakes(visualizer, rules, vocabulary)
                for widget in child.of("widget"):
                    yield from _widget_mistakes(widget, rules, vocabulary, viewport=child)
                    yield from inputs.claim(widget, robot_name, viewport=child)
            elif child.tag == "widget":
                yield from _widget_mistakes(child, rules, vocabulary, viewport=None)
                yield from inputs.claim(child, None)
    yield from _duplicates(viewports, "viewport", rules)
    yield from reference_mistakes(root, rules, vocabulary)


def viewport_robot(viewport: Node, robots: tuple[str, ...], rules: Rules) -> str:
    """The robot of a viewport: the one it names or the layout's only one; else empty."""
    if "robot" in viewport.attributes:
        return rules.value(viewport, "robot") or ""
    return robots[0] if len(robots) == 1 else ""


def _duplicates(nodes: Iterable[Node], what: str, rules: Rules) -> Iterator[Mistake]:
    first: dict[str, int] = {}
    for node in nodes:
        name = rules.value(node, "name")
        if name is None:
            continue
        if not name.isprintable():
            yield Mistake(node.line, f"the name {quoted(name)} holds a character without a picture")
        if name in first:
            message = f"the {what} {quoted(name)} is already in line {first[name]}"
            yield Mistake(node.line, f"{message}; give each {what} a name of its own")
        first.setdefault(name, node.line)


def _robot_mistakes(robot: Node, rules: Rules) -> Iterator[Mistake]:
    hub = rules.value(robot, "hub")
    if hub is not None and not _is_endpoint(hub):
        message = f"the hub {quoted(hub)} is no endpoint; write tcp://host:port or ipc://path"
        yield Mistake(robot.line, message)
    first: dict[str, int] = {}
    for capability in robot.of("capability"):
        name = rules.value(capability, "name")
        if name is None:
            continue
        if name not in names.CAPABILITY_INTERVALS_MS:
            allowed = hint(name, names.CAPABILITY_INTERVALS_MS)
            yield Mistake(capability.line, f"unknown capability {quoted(name)}{allowed}")
        elif name in first:
            message = f"the capability {name} is already in line {first[name]}; ask for it once"
            yield Mistake(capability.line, message)
        first.setdefault(name, capability.line)


def _is_endpoint(text: str) -> bool:
    if found := _TCP.fullmatch(text):
        return 1 <= int(found[2]) <= _LARGEST_PORT
    return _IPC.fullmatch(text) is not None


def _viewport_mistakes(
    viewport: Node, view: Node, robots: tuple[str, ...], rules: Rules
) -> Iterator[Mistake]:
    name = quoted(viewport.attributes.get("name", ""))
    robot = rules.value(viewport, "robot")
    if robot is not None and robots and robot not in {*robots, CHOSEN}:
        message = f"unknown robot {quoted(robot)} of viewport {name}{hint(robot, robots)}"
        yield Mistake(viewport.line, message)
    if "robot" not in viewport.attributes and len(robots) > 1:
        message = f"viewport {name} needs the attribute robot{hint('', robots)}"
        yield Mistake(viewport.line, message)
    for axis in "xy":
        length = _number(view, f"{axis}size", rules)
        start = _number(viewport, f"{axis}pos", rules)
        size = _number(viewport, f"{axis}size", rules)
        if length is None or start is None or size is None:
            continue
        if start >= length or start + size <= 0:
            place = f"it covers {axis} {start:g} to {start + size:g}, the view 0 to {length:g}"
            message = f"viewport {name} lies wholly outside the view: {place}"
            yield Mistake(viewport.line, message)
            break


def _number(node: Node, attribute: str, rules: Rules) -> float | None:
    text = rules.value(node, attribute)
    return None if text is None else float(text)


def _visualizer_mistakes(
    visualizer: Node, rules: Rules, vocabulary: Vocabulary
) -> Iterator[Mistake]:
    function = rules.value(visualizer, "function")
    if function is None:
        return
    line = visualizer.line
    kind = vocabulary.visualizers.get(function)
    if kind is None:
        allowed = hint(function, vocabulary.visualizers)
        yield Mistake(line, f"unknown visualizer {quoted(function)}{allowed}")
        return
    rule = kind.rule
    message = rules.value(visualizer, "message")
    if rule.any_message:
        if message and message not in BY_NAME:
            yield Mistake(line, f"unknown message {quoted(message)}{hint(message, BY_NAME)}")
    elif message is not None and message != rule.message:
        draws = f"draws {rule.message}" if rule.message else "draws no message, leave message out"
        yield Mistake(line, f"{function} cannot draw the message {quoted(message)}, it {draws}")
    option = rules.value(visualizer, "option")
    if option and float(option) and rule.option is None:
        yield Mistake(line, f"{function} has no option, leave option out")
    elif option is not None and rule.option is not None:
        yield from _value_mistakes(line, f"option of {function}", option, rule.option)
    yield from _option_mistakes(visualizer, function, rule.options, rules)
    text = rules.value(visualizer, "text")
    if text and not rule.text:
        yield Mistake(line, f"{function} shows no text, leave text out")
    elif text and not text.isprintable():
        bad = next(character for character in text if not character.isprintable())
        message = f"text of {function} holds the character U+{ord(bad):04X}, which has no picture"
        yield Mistake(line, message)


def _value_mistakes(line: int, what: str, value: str, rule: Option) -> Iterator[Mistake]:
    if rule.accepts(value):
        return
    begins = "it must be from" if isinstance(rule, NumberOption) else "it must be"
    yield Mistake(line, f"{what} is {quoted(value)[1:-1]}, {begins} {rule.allowed}")


def _widget_mistakes(
    widget: Node, rules: Rules, vocabulary: Vocabulary, *, viewport: Node | None
) -> Iterator[Mistake]:
    handler = rules.value(widget, "handler")
    for event in widget.of("event"):
        yield from input_mistakes(event, rules, within_viewport=viewport is not None)
    if handler is None:
        return
    kind = vocabulary.widgets.get(handler)
    if kind is None:
        allowed = hint(handler, vocabulary.widgets)
        yield Mistake(widget.line, f"unknown handler {quoted(handler)}{allowed}")
        return
    rule = kind.rule
    if rule.needs_robot and viewport is None:
        message = f"{handler} commands a robot, move it into one of the robot's viewports"
        yield Mistake(widget.line, message)
    yield from _option_mistakes(widget, handler, rule.options, rules)
    for event in widget.of("event"):
        yield from _control_mistakes(event, handler, rule, rules)
        if rule.pointed and rules.value(event, "key") is not None:
            message = f"{handler} has to know where, give its event a mouse button, not a key"
            yield Mistake(event.line, message)


def _option_mistakes(
    owner: Node, name: str, known: Mapping[str, Option], rules: Rules
) -> Iterator[Mistake]:
    first: dict[str, int] = {}
    for node in owner.of("option"):
        option = rules.value(node, "name")
        if option is None:
            continue
        if option not in known:
            allowed = hint(option, known) if known else ", it has none"
            yield Mistake(node.line, f"{name} has no option {quoted(option)}{allowed}")
            continue
        if option in first:
            message = f"the option {option} is already in line {first[option]}; give it once"
            yield Mistake(node.line, message)
        first.setdefault(option, node.line)
        value = rules.value(node, "value")
        if value is not None:
            yield from _value_mistakes(
                node.line, f"option {option} of {name}", value, known[option]
            )


def _control_mistakes(
    event: Node, handler: str, rule: HandlerRule, rules: Rules
) -> Iterator[Mistake]:
    control = rules.value(event, "control")
    if control is None or control in rule.controls or not (control or rule.controls):
        return
    if not rule.controls:
        message = f"{handler} has no control {quoted(control)}, leave control out"
    elif not control:
        message = f"an event of {handler} needs the attribute control{hint('', rule.controls)}"
    else:
        message = f"{handler} has no control {quoted(control)}{hint(control, rule.controls)}"
    yield Mistake(event.line, message)
