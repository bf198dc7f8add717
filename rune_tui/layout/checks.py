"""What a layout must keep beyond its schema: names that exist, keys that do not collide.

Values that break the schema are skipped here; the schema's own check has reported them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from rune_tui.layout import names
from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted

_TCP = re.compile(r"tcp://([A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\]):([0-9]{1,5})")
_IPC = re.compile(r"ipc://[^\x00]+")
_LARGEST_PORT = 65535


def find_mistakes(root: Node, rules: Rules) -> Iterator[Mistake]:
    """Everything wrong with a layout that its schema cannot say."""
    robots = root.of("robot")
    yield from _duplicates(robots, "robot", rules)
    for robot in robots:
        yield from _robot_mistakes(robot, rules)
    known = tuple(filter(None, (rules.value(robot, "name") for robot in robots)))
    keys = _Keys(rules)
    viewports: list[Node] = []
    for view in root.of("view"):
        for child in view.children:
            if child.tag == "viewport":
                viewports.append(child)
                robot_name = viewport_robot(child, known, rules)
                yield from _viewport_mistakes(child, view, known, rules)
                for widget in child.of("widget"):
                    yield from _widget_mistakes(widget, rules, within_viewport=True)
                    yield from keys.claim(widget, robot_name)
            elif child.tag == "widget":
                yield from _widget_mistakes(child, rules, within_viewport=False)
                yield from keys.claim(child, None)
    yield from _duplicates(viewports, "viewport", rules)


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
    if robot is not None and robots and robot not in robots:
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
    for visualizer in viewport.of("visualizer"):
        yield from _visualizer_mistakes(visualizer, rules)


def _number(node: Node, attribute: str, rules: Rules) -> float | None:
    text = rules.value(node, attribute)
    return None if text is None else float(text)


def _visualizer_mistakes(visualizer: Node, rules: Rules) -> Iterator[Mistake]:
    function = rules.value(visualizer, "function")
    if function is None:
        return
    line = visualizer.line
    rule = names.VISUALIZERS.get(function)
    if rule is None:
        allowed = hint(function, names.VISUALIZERS)
        yield Mistake(line, f"unknown visualizer {quoted(function)}{allowed}")
        return
    message = rules.value(visualizer, "message")
    if message is not None and message != rule.message:
        draws = f"draws {rule.message}" if rule.message else "draws no message, leave message out"
        yield Mistake(line, f"{function} cannot draw the message {quoted(message)}, it {draws}")
    option = _number(visualizer, "option", rules)
    if option and rule.option is None:
        yield Mistake(line, f"{function} has no option, leave option out")
    elif option is not None and rule.option is not None:
        yield from _range_mistakes(line, f"option of {function}", option, rule.option)
    text = rules.value(visualizer, "text")
    if text and not rule.text:
        yield Mistake(line, f"{function} shows no text, leave text out")
    elif text and not text.isprintable():
        bad = next(character for character in text if not character.isprintable())
        message = f"text of {function} holds the character U+{ord(bad):04X}, which has no picture"
        yield Mistake(line, message)


def _range_mistakes(
    line: int, what: str, value: float, rule: names.OptionRule
) -> Iterator[Mistake]:
    if not rule.least <= value <= rule.most:
        limits = f"{rule.least:g} to {rule.most:g} {rule.unit}".rstrip()
        yield Mistake(line, f"{what} is {value:g}, it must be from {limits}")


def _widget_mistakes(widget: Node, rules: Rules, *, within_viewport: bool) -> Iterator[Mistake]:
    handler = rules.value(widget, "handler")
    rule = names.HANDLERS.get(handler or "")
    for event in widget.of("event"):
        key = rules.value(event, "key")
        if key is not None and not names.is_key(key):
            yield Mistake(event.line, _unknown_key(key))
    if handler is None:
        return
    if rule is None:
        allowed = hint(handler, names.HANDLERS)
        yield Mistake(widget.line, f"unknown handler {quoted(handler)}{allowed}")
        return
    if rule.needs_robot and not within_viewport:
        message = f"{handler} commands a robot, move it into one of the robot's viewports"
        yield Mistake(widget.line, message)
    yield from _option_mistakes(widget, handler, rule, rules)
    for event in widget.of("event"):
        yield from _control_mistakes(event, handler, rule, rules)


def _option_mistakes(
    widget: Node, handler: str, rule: names.HandlerRule, rules: Rules
) -> Iterator[Mistake]:
    first: dict[str, int] = {}
    for option in widget.of("option"):
        name = rules.value(option, "name")
        if name is None:
            continue
        if name not in rule.options:
            allowed = hint(name, rule.options) if rule.options else ", it has none"
            yield Mistake(option.line, f"{handler} has no option {quoted(name)}{allowed}")
            continue
        if name in first:
            message = f"the option {name} is already in line {first[name]}; give it once"
            yield Mistake(option.line, message)
        first.setdefault(name, option.line)
        value = _number(option, "value", rules)
        if value is not None:
            what = f"option {name} of {handler}"
            yield from _range_mistakes(option.line, what, value, rule.options[name])


def _control_mistakes(
    event: Node, handler: str, rule: names.HandlerRule, rules: Rules
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


def _unknown_key(key: str) -> str:
    if (reported := names.KEYS_REPORTED_AS.get(key)) is not None:
        return f"unknown key {quoted(key)}; terminals report it as {reported}, write that"
    if names.is_key(lower := names.canonical_key(key)):
        return f"unknown key {quoted(key)}; did you mean {lower!r}?"
    nearest = hint(key, names.KEYS)
    return f"unknown key {quoted(key)}{nearest or '; ' + names.KEY_RULE}"


@dataclass(slots=True)
class _Keys:
    """Which keys are taken, and where; each key is reported once for each event."""

    rules: Rules
    anywhere: dict[str, int] = field(default_factory=dict)
    globally: dict[str, int] = field(default_factory=dict)
    by_handler: dict[tuple[str, str, str], tuple[Node, int]] = field(default_factory=dict)
    by_widget: dict[tuple[int, str, str], int] = field(default_factory=dict)

    def claim(self, widget: Node, robot: str | None) -> Iterator[Mistake]:
        """Take the keys of a widget, whose robot is None if it is global."""
        handler = self.rules.value(widget, "handler") or ""
        events = [
            (event.line, names.canonical_key(key), self.rules.value(event, "control") or "")
            for event in widget.of("event")
            if (key := self.rules.value(event, "key")) is not None
        ]
        for line, key, control in events:
            taken = self._taken(widget, robot, handler, key, control)
            if taken is not None:
                yield Mistake(line, f"the key {quoted(key)} {taken}; choose another key")
            self.by_widget.setdefault((id(widget), key, control), line)
        for line, key, _ in events:
            self.anywhere.setdefault(key, line)
            if robot is None:
                self.globally.setdefault(key, line)
            elif robot:
                self.by_handler.setdefault((robot, handler, key), (widget, line))

    def _taken(
        self, widget: Node, robot: str | None, handler: str, key: str, control: str
    ) -> str | None:
        if (line := self.by_widget.get((id(widget), key, control))) is not None:
            return f"is already bound by this widget in line {line}"
        if (line := self.globally.get(key)) is not None:
            return f"belongs to a global widget already, in line {line}"
        if robot is None and (line := self.anywhere.get(key)) is not None:
            return f"of this global widget is used already, in line {line}"
        if robot and (found := self.by_handler.get((robot, handler, key))) is not None:
            return f"is bound to {handler} of robot {quoted(robot)} already, in line {found[1]}"
        return None
