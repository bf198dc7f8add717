"""The rules for a layout beyond its schema: existing names, keys without collisions.

Values that break the schema are skipped here; the schema's own check has reported them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from hub.errors import EndpointError
from hub.gcm.catalog import BY_NAME
from hub.ipc.endpoints import connectable, endpoint_of
from rune_tui.layout import names
from rune_tui.layout.arrangement_checks import arrangement_mistakes
from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted, tag
from rune_tui.layout.inputs import TakenInputs, input_mistakes
from rune_tui.layout.joystick_checks import handler_mistakes, joystick_mistakes
from rune_tui.layout.joysticks import JoystickNodes
from rune_tui.layout.places import Place
from rune_tui.layout.references import reference_mistakes
from rune_tui.layout.rules import HandlerRule, NumberOption, Option, Vocabulary
from rune_tui.layout.spec import CHOSEN
from rune_tui.layout.wants import Wants


def find_mistakes(root: Node, rules: Rules, vocabulary: Vocabulary) -> Iterator[Mistake]:
    """All mistakes of a layout that its schema cannot find."""
    yield from _lacking(root, "robot")
    yield from _lacking(root, "view")
    robots = root.of("robot")
    fonts = root.of("font")
    yield from _duplicates(fonts, "font", rules)
    letters = tuple(dict.fromkeys(filter(None, (rules.value(font, "name") for font in fonts))))
    yield from _duplicates(robots, "robot", rules)
    for robot in robots:
        yield from _robot_mistakes(robot, rules)
    known = tuple(filter(None, (rules.value(robot, "name") for robot in robots)))
    viewports = [viewport for view in root.of("view") for viewport in view.of("viewport")]
    joysticks = JoystickNodes(root.of("joystick"), rules)
    yield from _joystick_mistakes(root, rules)
    inputs, wants = TakenInputs(rules, joysticks), Wants(robots, rules)
    for view in root.of("view"):
        yield from arrangement_mistakes(view, rules)
        yield from _duplicates(view.of("arrangement"), "arrangement", rules)
        for child in view.children:
            if child.tag == "viewport":
                robot_name = viewport_robot(child, known, rules)
                yield from _viewport_mistakes(child, known, rules)
                for visualizer in child.of("visualizer"):
                    yield from _visualizer_mistakes(visualizer, rules, vocabulary)
                    yield from _font_mistakes(visualizer, letters, rules, vocabulary)
                    yield from _undrawn(visualizer, robot_name, rules, vocabulary, wants)
                for widget in child.of("widget"):
                    yield from _widget_mistakes(widget, rules, vocabulary, joysticks, child)
                    yield from _unheard(widget, robot_name, rules, vocabulary, wants)
                    yield from inputs.claim(widget, robot_name, viewport=child)
            elif child.tag == "widget":
                yield from _widget_mistakes(child, rules, vocabulary, joysticks)
                yield from inputs.claim(child, None)
    yield from _duplicates(viewports, "viewport", rules)
    yield from reference_mistakes(root, rules, vocabulary)


def _lacking(node: Node, child: str) -> Iterator[Mistake]:
    """Missing elements that a part may bring, so that the schema cannot require them."""
    if not node.of(child):
        yield Mistake(node.place, f"{tag(node.tag)} needs a {tag(child)} in it")


def viewport_robot(viewport: Node, robots: tuple[str, ...], rules: Rules) -> str:
    """The robot of a viewport: the one it names or the layout's only one; else empty."""
    if "robot" in viewport.attributes:
        return rules.value(viewport, "robot") or ""
    return robots[0] if len(robots) == 1 else ""


def _duplicates(nodes: Iterable[Node], what: str, rules: Rules) -> Iterator[Mistake]:
    first: dict[str, Place] = {}
    for node in nodes:
        name = rules.value(node, "name")
        if name is None:
            continue
        if not name.isprintable():
            yield Mistake(
                node.at("name"), f"the name {quoted(name)} holds a character without a picture"
            )
        if name in first:
            message = f"the {what} {quoted(name)} is already in {first[name].seen_from(node.place)}"
            yield Mistake(node.at("name"), f"{message}; give each {what} a name of its own")
        first.setdefault(name, node.place)


def _robot_mistakes(robot: Node, rules: Rules) -> Iterator[Mistake]:
    hub = rules.value(robot, "hub")
    if hub is not None and not _is_endpoint(endpoint_of(hub)):
        message = (
            f"the hub {quoted(hub)} is no endpoint; write a hub's name, host:port or ipc://path"
        )
        yield Mistake(robot.at("hub"), message)
    first: dict[str, Place] = {}
    for capability in robot.of("capability"):
        name = rules.value(capability, "name")
        if name is None:
            continue
        if name not in names.CAPABILITY_INTERVALS_MS:
            allowed = hint(name, names.CAPABILITY_INTERVALS_MS)
            yield Mistake(capability.at("name"), f"unknown capability {quoted(name)}{allowed}")
        elif name in first:
            message = (
                f"the capability {name} is already in {first[name].seen_from(capability.place)}"
            )
            yield Mistake(capability.at("name"), f"{message}; ask for it once")
        first.setdefault(name, capability.place)


def _is_endpoint(text: str) -> bool:
    try:
        connectable(text, with_keys=True)  # the layout does not show whether there are keys
    except EndpointError:
        return False
    return True


def _viewport_mistakes(viewport: Node, robots: tuple[str, ...], rules: Rules) -> Iterator[Mistake]:
    name = quoted(viewport.attributes.get("name", ""))
    robot = rules.value(viewport, "robot")
    if robot is not None and robots and robot not in {*robots, CHOSEN}:
        message = f"unknown robot {quoted(robot)} of viewport {name}{hint(robot, robots)}"
        yield Mistake(viewport.at("robot"), message)
    if "robot" not in viewport.attributes and len(robots) > 1:
        message = f"viewport {name} needs the attribute robot{hint('', robots)}"
        yield Mistake(viewport.place, message)


def _visualizer_mistakes(
    visualizer: Node, rules: Rules, vocabulary: Vocabulary
) -> Iterator[Mistake]:
    function = rules.value(visualizer, "function")
    if function is None:
        return
    kind = vocabulary.visualizers.get(function)
    if kind is None:
        unknown = f"unknown visualizer {quoted(function)}{hint(function, vocabulary.visualizers)}"
        yield Mistake(visualizer.at("function"), vocabulary.faults.get(function, unknown))
        return
    rule = kind.rule
    message = rules.value(visualizer, "message")
    if rule.any_message:
        if message and message not in BY_NAME:
            wrong = f"unknown message {quoted(message)}{hint(message, BY_NAME)}"
            yield Mistake(visualizer.at("message"), wrong)
    elif message is not None and message != rule.message:
        draws = f"draws {rule.message}" if rule.message else "draws no message, leave message out"
        wrong = f"{function} cannot draw the message {quoted(message)}, it {draws}"
        yield Mistake(visualizer.at("message"), wrong)
    option = rules.value(visualizer, "option")
    if option and float(option) and rule.option is None:
        yield Mistake(visualizer.at("option"), f"{function} has no option, leave option out")
    elif option is not None and rule.option is not None:
        place = visualizer.at("option")
        yield from _value_mistakes(place, f"option of {function}", option, rule.option)
    yield from _option_mistakes(visualizer, function, rule.options, rules)
    text = rules.value(visualizer, "text")
    if text and not rule.text:
        yield Mistake(visualizer.at("text"), f"{function} shows no text, leave text out")
    elif text and not text.isprintable():
        bad = next(character for character in text if not character.isprintable())
        message = f"text of {function} holds the character U+{ord(bad):04X}, which has no picture"
        yield Mistake(visualizer.at("text"), message)


def _font_mistakes(
    visualizer: Node, fonts: tuple[str, ...], rules: Rules, vocabulary: Vocabulary
) -> Iterator[Mistake]:
    font, function = rules.value(visualizer, "font"), rules.value(visualizer, "function")
    if font is None:
        return
    kind = vocabulary.visualizers.get(function or "")
    if kind is not None and not kind.rule.font:
        message = f"{function} writes in the terminal's letters alone, leave font out"
        yield Mistake(visualizer.at("font"), message)
    elif font not in fonts:
        message = f"unknown font {quoted(font)}{hint(font, fonts)}; name it in a <font>"
        yield Mistake(visualizer.at("font"), message)


def _value_mistakes(place: Place, what: str, value: str, rule: Option) -> Iterator[Mistake]:
    if rule.accepts(value):
        return
    begins = "it must be from" if isinstance(rule, NumberOption) else "it must be"
    yield Mistake(place, f"{what} is {quoted(value)[1:-1]}, {begins} {rule.allowed}")


def _joystick_mistakes(root: Node, rules: Rules) -> Iterator[Mistake]:
    nodes = root.of("joystick")
    yield from joystick_mistakes(nodes, rules)
    yield from _duplicates(nodes, "joystick", rules)
    for node in nodes:
        yield from _duplicates(node.of("control"), "control", rules)


def _widget_mistakes(
    widget: Node,
    rules: Rules,
    vocabulary: Vocabulary,
    joysticks: JoystickNodes,
    viewport: Node | None = None,
) -> Iterator[Mistake]:
    yield from _lacking(widget, "event")
    handler = rules.value(widget, "handler")
    for event in widget.of("event"):
        yield from input_mistakes(event, rules, viewport, joysticks)
    if handler is None:
        return
    kind = vocabulary.widgets.get(handler)
    if kind is None:
        unknown = f"unknown handler {quoted(handler)}{hint(handler, vocabulary.widgets)}"
        yield Mistake(widget.at("handler"), vocabulary.faults.get(handler, unknown))
        return
    rule = kind.rule
    if rule.needs_robot and viewport is None:
        message = f"{handler} commands a robot, move it into one of the robot's viewports"
        yield Mistake(widget.at("handler"), message)
    yield from _option_mistakes(widget, handler, rule.options, rules)
    for event in widget.of("event"):
        if not any(each.pushed for each in joysticks.inputs(event)):
            yield from _control_mistakes(event, handler, rule, rules)
        yield from handler_mistakes(event, handler, rule, rules, joysticks)
        if rule.pointed and rules.value(event, "key") is not None:
            message = f"{handler} has to know where, give its event a mouse button, not a key"
            yield Mistake(event.at("key"), message)


def _option_mistakes(
    owner: Node, name: str, known: Mapping[str, Option], rules: Rules
) -> Iterator[Mistake]:
    first: dict[str, Place] = {}
    for node in owner.of("option"):
        option = rules.value(node, "name")
        if option is None:
            continue
        if option not in known:
            allowed = hint(option, known) if known else ", it has none"
            yield Mistake(node.at("name"), f"{name} has no option {quoted(option)}{allowed}")
            continue
        if option in first:
            message = f"the option {option} is already in {first[option].seen_from(node.place)}"
            yield Mistake(node.at("name"), f"{message}; give it once")
        first.setdefault(option, node.place)
        value = rules.value(node, "value")
        if value is not None:
            yield from _value_mistakes(
                node.at("value"), f"option {option} of {name}", value, known[option]
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
    yield Mistake(event.at("control"), message)


def _undrawn(
    visualizer: Node, robot: str, rules: Rules, vocabulary: Vocabulary, wants: Wants
) -> Iterator[Mistake]:
    function = rules.value(visualizer, "function")
    kind = vocabulary.visualizers.get(function or "")
    if function and kind:
        message = rules.value(visualizer, "message")
        drawn = message if message and kind.rule.any_message else kind.rule.message
        place = visualizer.at("message" if message else "function")
        yield from wants.undrawn(drawn, function, robot, place)


def _unheard(
    widget: Node, robot: str, rules: Rules, vocabulary: Vocabulary, wants: Wants
) -> Iterator[Mistake]:
    handler = rules.value(widget, "handler")
    kind = vocabulary.widgets.get(handler or "")
    if handler and kind:
        yield from wants.unheard(kind.rule.sends, handler, robot, widget.at("handler"))
