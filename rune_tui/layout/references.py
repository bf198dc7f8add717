"""Options that name a robot or a viewport of the layout: it has to be there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted
from rune_tui.layout.rules import Option, TextOption, Vocabulary


def reference_mistakes(root: Node, rules: Rules, vocabulary: Vocabulary) -> Iterator[Mistake]:
    """Names in options that nothing in the layout has."""
    views = root.of("view")
    viewports = [viewport for view in views for viewport in view.of("viewport")]
    known = {
        "robot": _names(root.of("robot"), rules),
        "viewport": _names(viewports, rules),
    }
    for owner in (*views, *viewports):
        for tag, attribute in (("visualizer", "function"), ("widget", "handler")):
            for node in owner.of(tag):
                name = rules.value(node, attribute) or ""
                kinds = vocabulary.visualizers if tag == "visualizer" else vocabulary.widgets
                if name in kinds:
                    options = kinds[name].rule.options
                    yield from _unknown(node, name, options, known, rules)
                    if owner.tag == "view":
                        yield from _missing(node, name, options, rules)


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
            if value not in there:
                message = f"unknown {option.names} {quoted(value)} of {name}{hint(value, there)}"
                yield Mistake(node.at("value"), message)


def _missing(
    owner: Node, name: str, options: Mapping[str, Option], rules: Rules
) -> Iterator[Mistake]:
    """A widget in no viewport has none of its own to be meant by silence."""
    given = {rules.value(node, "name") for node in owner.of("option") if rules.value(node, "value")}
    for option, rule in options.items():
        if isinstance(rule, TextOption) and rule.names == "viewport" and option not in given:
            message = f"{name} is in no viewport, so it needs the option {option}"
            yield Mistake(owner.place, message)
