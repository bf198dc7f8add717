"""Options that name a robot, a viewport, a joystick or a message's field: it has to be there."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence

from hub.gcm.catalog import BY_NAME
from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted
from rune_tui.layout.rules import HandlerRule, Option, TextOption, VisualizerRule, Vocabulary

_ROOT = re.compile(r"[.\[]")
"""Where the name of a message's own field ends in a path such as points[1].x."""


def reference_mistakes(root: Node, rules: Rules, vocabulary: Vocabulary) -> Iterator[Mistake]:
    """Names in options that nothing in the layout has."""
    views = root.of("view")
    viewports = [viewport for view in views for viewport in view.of("viewport")]
    known = {
        "robot": _names(root.of("robot"), rules),
        "viewport": _names(viewports, rules),
        "joystick": _names(root.of("joystick"), rules),
    }
    for owner in (*views, *viewports):
        for tag, attribute in (("visualizer", "function"), ("widget", "handler")):
            for node in owner.of(tag):
                name = rules.value(node, attribute) or ""
                kinds = vocabulary.visualizers if tag == "visualizer" else vocabulary.widgets
                if name in kinds:
                    options = kinds[name].rule.options
                    fields = _fields(node, kinds[name].rule, rules)
                    yield from _unknown(node, name, options, known | {"field": fields}, rules)
                    if owner.tag == "view":
                        yield from _missing(node, name, options, rules)


def _fields(node: Node, rule: VisualizerRule | HandlerRule, rules: Rules) -> tuple[str, ...]:
    """The fields of the message that a visualizer draws."""
    if not isinstance(rule, VisualizerRule):
        return ()
    definition = BY_NAME.get(rules.value(node, "message") or rule.message)
    return tuple(each.name for each in dataclasses.fields(definition.type)) if definition else ()


def _names(nodes: Sequence[Node], rules: Rules) -> tuple[str, ...]:
    return tuple(filter(None, (rules.value(node, "name") for node in nodes)))


def _unknown(
    owner: Node,
    name: str,
    options: Mapping[str, Option],
    known: Mapping[str, tuple[str, ...]],
    rules: Rules,
) -> Iterator[Mistake]:
    for node in owner.of("option"):
        option = options.get(rules.value(node, "name") or "")
        value = rules.value(node, "value")
        if value and isinstance(option, TextOption) and option.names:
            there = known[option.names]
            named = _ROOT.split(value)[0] if option.names == "field" else value
            if named not in there and (there or option.names != "field"):
                message = f"unknown {option.names} {quoted(value)} of {name}{hint(value, there)}"
                yield Mistake(node.at("value"), message)


def _missing(
    owner: Node, name: str, options: Mapping[str, Option], rules: Rules
) -> Iterator[Mistake]:
    """A widget in no viewport has no default viewport."""
    given = {rules.value(node, "name") for node in owner.of("option") if rules.value(node, "value")}
    for option, rule in options.items():
        if isinstance(rule, TextOption) and rule.names == "viewport" and option not in given:
            message = f"{name} is in no viewport, so it needs the option {option}"
            yield Mistake(owner.place, message)
