"""The actions of a layout's inputs, in words, for the help and for the list of actions."""

from __future__ import annotations

import contextlib
import dataclasses
import re
from collections.abc import Iterator

from hub.values import dataclass
from rune_tui.layout.input_words import ways
from rune_tui.layout.names import MOUSE
from rune_tui.layout.rules import (
    ChoiceOption,
    HandlerRule,
    NumberOption,
    Option,
    Purpose,
    Section,
    TextOption,
)
from rune_tui.layout.spec import ControlKind, EventSpec, LayoutSpec, ViewportSpec, WidgetSpec

_WHEEL = MOUSE + "wheel"
_WORDS = re.compile("[A-Z]+(?![a-z])|[A-Z]?[a-z]+")


@dataclass(frozen=True, slots=True, kw_only=True)
class Action:
    """Something that one or several inputs do.

    Attributes:
        words: Their action.
        help: The same at length.
        also: Further words by which the list finds it: those of its rule, and its handler's name.
        inputs: Which they are, in words.
        robot: Its robot; empty: the console itself.
        event: The first of their events, as the layout has it.
        section: Where the help lists it.
        safe: Whether its inputs count while a page covers the view, as those of the stop do.
        at_once: Whether it needs no time, no pointing and no direction, so that it
            can be chosen from a list.
    """

    words: str
    help: str
    also: str
    inputs: tuple[str, ...]
    robot: str
    event: EventSpec
    section: Section
    safe: bool
    at_once: bool


def actions_of(layout: LayoutSpec) -> tuple[Action, ...]:
    """All actions of a layout's inputs, the console's own first, then by robot."""
    merged: dict[tuple[str, str], Action] = {}
    for action in _single_actions(layout):
        key = (action.robot, action.words)
        known = merged.get(key, action)
        inputs = tuple(dict.fromkeys((*known.inputs, *action.inputs)))
        merged[key] = dataclasses.replace(known, inputs=inputs)
    order = ["", *(robot.name for robot in layout.robots)]
    robots = [*order, *(robot for robot, _ in merged if robot not in order)]
    return tuple(sorted(merged.values(), key=lambda action: robots.index(action.robot)))


def inputs_of(layout: LayoutSpec) -> dict[tuple[Purpose, str], str]:
    """The first input of each purpose, in words, by the purpose and the robot it is for.

    That is the robot of its option `robot`, if it has one, else the one of its viewport.
    """
    owners = [("", layout.view.widgets)]
    owners += [(viewport.robot, viewport.widgets) for viewport in layout.view.viewports]
    found: dict[tuple[Purpose, str], str] = {}
    for robot, widgets in owners:
        for widget in widgets:
            rule, chosen = layout.vocabulary.widgets[widget.handler].rule, widget.options.values
            purpose = rule.purpose if rule.purpose_with.items() <= chosen.items() else None
            if purpose is not None and widget.events:
                said, _ = next(ways(widget.events[0], layout.joysticks))
                meant = chosen.get("robot", robot)
                found.setdefault((purpose, str(meant)), said)
    return found


def _single_actions(layout: LayoutSpec) -> Iterator[Action]:
    owners = [("", "", layout.view.widgets)]
    owners += [(each.robot, _where(each), each.widgets) for each in layout.view.viewports]
    for owner, where, widgets in owners:
        for widget in widgets:
            rule = layout.vocabulary.widgets[widget.handler].rule
            for event in widget.events:
                for said, moved in ways(event, layout.joysticks, where):
                    yield Action(
                        words=_words(widget, moved, rule),
                        help=rule.meaning,
                        also=f"{rule.also} {_name_in_words(widget.handler)}",
                        inputs=(said,),
                        robot=owner if rule.needs_robot else "",
                        event=event,
                        section=rule.section
                        or (Section.ROBOT if rule.needs_robot else Section.SCREEN),
                        safe=rule.under_help,
                        at_once=not (rule.pointed or rule.held or _both_ways(event)),
                    )


def _name_in_words(handler: str) -> str:
    """The words of a handler's name: "take over" for "widgetTakeOver"."""
    return " ".join(_WORDS.findall(handler.removeprefix("widget"))).lower()


def _both_ways(event: EventSpec) -> bool:
    """Whether an input has no one direction."""
    return event.name == _WHEEL or event.kind in {ControlKind.AXIS, ControlKind.BALL}


def _where(viewport: ViewportSpec) -> str:
    """The mouse's place: the text of a button there, or the viewport's name."""
    text = viewport.visualizer.text if viewport.visualizer else ""
    return f" at {text}" if text else f" in {viewport.name}"


def _words(widget: WidgetSpec, event: EventSpec, rule: HandlerRule) -> str:
    if template := rule.says.get(event.control, rule.says.get("", "")):
        # A rule of an extension may name a missing action.
        with contextlib.suppress(KeyError, ValueError, IndexError, AttributeError):
            return template.format_map(_values(widget, event, rule))
    said = rule.meaning.split(". ")[0].split(";")[0].rstrip(".")
    if more := ", ".join(filter(None, (_direction(event, rule), *_options(widget, event, rule)))):
        said += f": {more}"
    return said


def _values(widget: WidgetSpec, event: EventSpec, rule: HandlerRule) -> dict[str, str]:
    """The values of the names in braces in a rule's words."""
    values = {"direction": _direction(event, rule)}
    for name, option in rule.options.items():
        value = widget.options.values[name]
        if isinstance(option, TextOption) and option.names:
            own = widget.viewport if option.names == "viewport" else "the next one"
            values[name] = str(value) or own
        elif isinstance(option, ChoiceOption):
            values[name] = option.words.get(str(value), str(value))
        elif isinstance(option, TextOption):
            values[name] = str(value) or option.unnamed
        else:
            values[name] = _shown(value, option)
    return values


def _direction(event: EventSpec, rule: HandlerRule) -> str:
    if event.control not in rule.words:
        return event.control
    plus, minus = rule.words[event.control]
    if event.name == _WHEEL or event.kind is ControlKind.BALL:
        return f"{plus} or {minus}" if event.value >= 0.0 else f"{minus} or {plus}"
    size = abs(event.value)
    share = "" if size == 1.0 else f", {100 * size:.0f} %"
    return (plus if event.value >= 0.0 else minus) + share


def _options(widget: WidgetSpec, event: EventSpec, rule: HandlerRule) -> Iterator[str]:
    """The options that the layout sets, and those that are amounts, names or places."""
    for name, option in rule.options.items():
        value = widget.options.values[name]
        if isinstance(option, TextOption) and option.names == "viewport":
            value = value or widget.viewport
        others = (control for control in rule.controls if control != event.control)
        if value and not name.startswith(tuple(f"{control}_" for control in others)):
            yield f"{_option_name(name, option)} {_shown(value, option)}"


def _option_name(name: str, option: Option) -> str:
    unit = option.unit if isinstance(option, NumberOption) else ""
    return (name.removesuffix(f"_{unit}") if unit else name).replace("_", " ")


def _shown(value: float | str, option: Option) -> str:
    if isinstance(option, NumberOption) and isinstance(value, float | int):
        return f"{value:g} {option.unit}".rstrip()
    return str(value)
