"""Keys that cannot be answers of the secondary task: others use them, or there are none such."""

from __future__ import annotations

from collections.abc import Iterator

from rune_study.plan.folder import layout_of
from rune_study.plan.study_spec import ConditionSpec, StudySpec


def task_key_problems(study: StudySpec) -> Iterator[str]:
    """What is wrong with the keys of answers, a sentence each."""
    from rune_tui.layout.names import KEY_RULE, WAY_OUT, canonical_key, is_key

    given = study.task.keys if study.task is not None else ()
    wanted = {canonical_key(each): each for each in given}
    for name, each in wanted.items():
        if name == WAY_OUT:
            yield f"{each!r} ends the console always; choose another key"
        elif not is_key(name):
            yield f"{each!r} is no key: {KEY_RULE}"
    for layout in dict.fromkeys(spec.layout for spec in study.conditions):
        spec = next(each for each in study.conditions if each.layout == layout)
        for name in sorted(_used(study, spec).intersection(wanted)):
            yield f"{wanted[name]!r} is a key of the layout {layout!r}; choose another key"


def _used(study: StudySpec, spec: ConditionSpec) -> set[str]:
    """Keys to which a layout binds something; none if it cannot be read."""
    from rune_tui.errors import LayoutError
    from rune_tui.startup.opening import open_layout

    try:
        view = open_layout(layout_of(study, spec), dict(spec.variables)).view
    except LayoutError:
        return set()
    widgets = [*view.widgets, *(each for port in view.viewports for each in port.widgets)]
    return {event.name for widget in widgets for event in widget.events}
