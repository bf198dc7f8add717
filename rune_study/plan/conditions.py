"""What robots may do by themselves in a condition: in words, as limits, and by its layout."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hub.gcm.autonomy import AUTONOMY_COMMAND, AutonomyCommand, Behaviour
from hub.gcm.navigation import ASSISTANCE_COMMAND, GOAL_COMMAND, TURN_COMMAND
from rune_study.plan.steps import codes
from rune_study.plan.study_spec import ConditionSpec, StudySpec
from rune_tui.layout.spec import LayoutSpec, WidgetSpec
from rune_tui.model.operating_limits import (
    AssistanceRule,
    AutonomyLevel,
    OperatingLimits,
    needed_for,
)

_KEYS = ("autonomy", "assistance")
_ORDER = "order"
"""The option that says what a widget tells autonomy."""


def limits_of(spec: ConditionSpec) -> OperatingLimits:
    """What robots may do by themselves in a condition."""
    whole = OperatingLimits()
    autonomy = AutonomyLevel[spec.autonomy.upper()] if spec.autonomy else whole.autonomy
    return OperatingLimits(
        autonomy=autonomy, assistance=AssistanceRule(spec.assistance or whole.assistance)
    )


def limit_words(spec: ConditionSpec) -> dict[str, str]:
    """The levels that a condition sets, by their keys."""
    return {key: getattr(spec, key) for key in _KEYS if getattr(spec, key)}


def words_of(study: StudySpec, number: int) -> str:
    """A condition in words: levels of its factors, and what its robots may do by themselves."""
    spec = study.conditions[number]
    levels: dict[str, Any] = {**limit_words(spec), **study.levels[number]}
    ordered = [*study.levels[number], *(name for name in levels if name in _KEYS)]
    return ", ".join(f"{name} {levels[name]}" for name in dict.fromkeys(ordered))


def condition_lines(study: StudySpec) -> Iterator[str]:
    """A line for each condition: its code, and the condition in words."""
    numbered = sorted((code, number) for number, code in enumerate(codes(study)))
    for code, number in numbered:
        yield f"{code}  {words_of(study, number) or 'the only condition'}"


def shared_words(study: StudySpec) -> str:
    """The levels that all conditions share without a factor, in words; empty: none."""
    factors = set().union(*study.levels)
    all_of = [limit_words(spec).items() for spec in study.conditions]
    shared = set(all_of[0]).intersection(*all_of) if all_of else set()
    return ", ".join(f"{name} {level}" for name, level in sorted(shared) if name not in factors)


def layout_problems(spec: ConditionSpec, layout: LayoutSpec) -> Iterator[tuple[str, str]]:
    """Levels of a condition that its layout has no input for: keys, and a sentence each."""
    offered = _offered(layout)
    if spec.autonomy and offered < limits_of(spec).autonomy:
        what = "goals or turns" if spec.autonomy == "goals" else "exploration"
        text = (
            f"autonomy {spec.autonomy!r}: layout {spec.layout!r} has no input for {what}; bind "
            f"one, or write {offered.name.lower()!r}"
        )
        yield "autonomy", text
    switches = any(ASSISTANCE_COMMAND.name in robot.commands for robot in layout.robots)
    if spec.assistance == AssistanceRule.SWITCHED.value and not switches:
        text = (
            f"assistance 'switched': layout {spec.layout!r} has no input that switches it; bind "
            "widgetSafety, or write 'on' or 'off'"
        )
        yield "assistance", text


def _offered(layout: LayoutSpec) -> AutonomyLevel:
    """The most that robots do by themselves with the inputs of a layout."""
    owners = (layout.view.widgets, *(viewport.widgets for viewport in layout.view.viewports))
    found = [_needs(layout, widget) for widgets in owners for widget in widgets]
    return max(found, default=AutonomyLevel.TELEOPERATION)


def _needs(layout: LayoutSpec, widget: WidgetSpec) -> AutonomyLevel:
    sends = layout.vocabulary.widgets[widget.handler].rule.sends
    if AUTONOMY_COMMAND.name in sends:
        order = str(widget.options.values.get(_ORDER, "")).upper()
        if order not in Behaviour.__members__:
            return AutonomyLevel.EXPLORATION
        command = AutonomyCommand(behaviour=Behaviour[order])
        return needed_for(AUTONOMY_COMMAND.name, command)
    goes = {GOAL_COMMAND.name, TURN_COMMAND.name} & {*sends}
    return AutonomyLevel.GOALS if goes else AutonomyLevel.TELEOPERATION


def not_kept(study: StudySpec) -> Iterator[str]:
    """What the study cannot keep on real robots, a sentence each."""
    for code, number in sorted((code, number) for number, code in enumerate(codes(study))):
        spec = study.conditions[number]
        if spec.hubs and limit_words(spec):
            which = "a condition" if study.design.blind else f"condition {code}"
            yield (
                f"{which} limits real robots ({', '.join(limit_words(spec))}) at the participant's "
                "console alone; other consoles and programs must leave these robots alone"
            )
