"""All that is wrong with a study: its file, and the files and metrics that it names."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hub.errors import HubError
from hub.nearest import did_you_mean
from hub.plain_text import plain
from hub.robots.robot_file import find_robot_file, read_description
from hub.shaper.profile import load_profile
from hub.sim.arena import load_arena
from rune_study.errors import QuestionnaireError
from rune_study.metrics.registry import METRICS
from rune_study.plan.conditions import layout_problems, limits_of
from rune_study.plan.folder import (
    arena_of,
    hub_settings,
    layout_of,
    link_of,
    questionnaire_path,
    robot_of,
    text_path,
)
from rune_study.plan.practice import practice_of
from rune_study.plan.real_robots import not_for_real
from rune_study.plan.steps import BREAK, PRACTICE, SECONDARY, TRIALS
from rune_study.plan.study_file import StudyDraft, read_draft
from rune_study.plan.study_spec import ConditionSpec, StudySpec
from rune_study.plan.task_keys import task_key_problems
from rune_study.questionnaires.items import ComparedItem, Item, PlaceItem
from rune_study.questionnaires.questionnaire import read, shipped
from rune_study.trial_data.measured import EFFECTIVENESS

_OWN_STEPS = (TRIALS, PRACTICE, BREAK, SECONDARY)
_QUESTIONNAIRES = {"tlx_raw": "nasa-tlx", "tlx_weighted": "nasa-tlx", "sus": "sus", "sart": "sart"}
"""Questionnaires that metrics need."""
_OF_TASK = ("ft_secondary", "secondary_right", "secondary_missed", "secondary_time")
_OF_VICTIMS = ("victims_", "first_victim", "coverage", "map_")


def check_study(folder: Path) -> StudyDraft:
    """Read a study, and add all that is wrong with what it names to its problems.

    Raises:
        StudyFileError: Its file cannot be read, or is not TOML.
    """
    draft = read_draft(folder)
    for place, key, problem in sorted(
        {*_steps(draft), *_conditions(draft), *_alike(draft), *_metrics(draft), *_keys(draft)}
    ):
        draft.problems.add(place, problem, key)
    return draft


def _keys(draft: StudyDraft) -> Iterator[_Problem]:
    """Keys of the secondary task that cannot be its answers."""
    if "secondary" in draft.sound:
        for problem in task_key_problems(draft.study):
            yield "[secondary]", "keys", f"[secondary], key 'keys': {problem}"


def _alike(draft: StudyDraft) -> Iterator[_Problem]:
    """Conditions that do not differ: in a name alone, or in a level that changes nothing."""
    study = draft.study
    found: dict[ConditionSpec, Mapping[str, Any]] = {}
    for spec, levels in zip(study.conditions, study.levels, strict=False):
        limits = limits_of(spec)
        effect = dataclasses.replace(
            spec, assistance=limits.assistance.value, autonomy=limits.autonomy.name
        )
        other = found.setdefault(effect, levels)
        if other is not levels:
            names = [name for name in levels if levels[name] != other.get(name)]
            if draft.refused.intersection(names):
                continue  # a level that is none is named already
            for name in names:
                text = (
                    f"[factors]: {name} {other.get(name)!r} and {levels[name]!r} do not differ; "
                    "a [[level]] says what each changes"
                )
                yield "[factors]", name, text


_Problem = tuple[str, str, str]
"""Its table, its key, and a sentence."""


def _steps(draft: StudyDraft) -> Iterator[_Problem]:
    """Steps without a page, and questionnaires with mistakes."""
    study = draft.study
    named: list[tuple[str, str, str]] = []
    if "session" in draft.sound:
        named += [("[session]", "steps", name) for name in study.session.steps]
    if "trial" in draft.sound:
        named += [("[trial]", "before", name) for name in study.trial.before]
        named += [("[trial]", "after", name) for name in study.trial.after]
    if study.freeze is not None and "freeze" in draft.sound:
        named.append(("[freeze]", "questions", study.freeze.questions))
    for place, key, name in named:
        if place == "[session]" and name in _OWN_STEPS:
            continue
        path = questionnaire_path(study, name)
        if path is not None:
            try:
                items = read(path).items
            except QuestionnaireError as error:
                yield place, key, f"{place}, key '{key}': {plain(str(error), lines=True)}"
                continue
            for problem in _question_problems(study, items, frozen=place == "[freeze]"):
                yield place, key, f"{place}, key '{key}': {name}: {problem}"
        elif text_path(study, name) is None or place == "[freeze]":
            kinds = "a questionnaire" if place == "[freeze]" else "a step"
            wanted = f"questionnaires/{name}.toml"
            wanted = wanted if place == "[freeze]" else f"texts/{name}.md or {wanted}"
            hint = did_you_mean(name, _known_steps(study)) or f"; write {wanted}"
            yield place, key, f"{place}, key '{key}': there is no {kinds[2:]} {name!r}{hint}"


def _question_problems(study: StudySpec, items: Iterable[Item], *, frozen: bool) -> Iterator[str]:
    """Questions that cannot be asked there, a sentence each."""
    robots = min((spec.robots for spec in study.conditions), default=1)
    for item in items:
        if not isinstance(item, ComparedItem):
            continue
        if not frozen and (item.truth or isinstance(item, PlaceItem)):
            what = "names a truth" if item.truth else "asks for a place"
            yield f"{item.id} {what}, which only the questions of [freeze] can"
        if item.robot > robots:
            yield f"{item.id} asks about robot {item.robot}, and a condition has {robots}"


def _known_steps(study: StudySpec) -> list[str]:
    texts = (path.stem for path in (study.folder / "texts").glob("*.md"))
    own = (path.stem for path in (study.folder / "questionnaires").glob("*.toml"))
    return sorted({*_OWN_STEPS, *texts, *own, *shipped()})


def _conditions(draft: StudyDraft) -> Iterator[_Problem]:
    """Layouts, robots, arenas and links of conditions and practice that cannot be used."""
    study = draft.study
    crossed = set().union(*study.levels)
    for spec in dict.fromkeys(study.conditions):
        for key, problem in condition_problems(study, spec, draft.refused):
            yield "[factors]" if key in crossed else "[defaults]", key, problem
    if study.practice is not None and "practice" in draft.sound and study.conditions:
        spec = practice_of(study, study.conditions[0])
        for key, problem in condition_problems(study, spec, draft.refused):
            if getattr(study.practice, key, ""):
                yield "[practice]", key, problem


def condition_problems(
    study: StudySpec, spec: ConditionSpec, refused: Iterable[str] = ()
) -> Iterator[tuple[str, str]]:
    """Why the parts of a condition cannot be used: keys, and a sentence each.

    Args:
        study: The study.
        spec: The condition.
        refused: Keys that have a mistake themselves; what follows from them is left out.
    """
    if "variables" not in refused:
        yield from _layout_problems(study, spec, {*refused})
    if spec.hubs:
        if len(spec.hubs) != spec.robots:
            yield "hubs", f"'hubs' names {len(spec.hubs)} robots, and 'robots' = {spec.robots}"
        yield from not_for_real(spec)
    parts: tuple[tuple[str, Callable[[str], object], str], ...] = (
        ("robot", find_robot_file, robot_of(study, spec)),
        ("arena", load_arena, arena_of(study, spec)),
        ("link", load_profile, link_of(study, spec)),
    )
    sound = True
    for name, load, path in parts:
        try:
            if path:
                load(path)
        except HubError as error:
            sound = False
            hint = _own_hint(study, f"{name}s", path)
            yield name, f"{name} {plain(str(error), lines=True)}{hint}"
    if sound:
        settings = hub_settings(study, spec, seed=1)
        try:
            for problem in read_description(find_robot_file(robot_of(study, spec)), settings)[1]:
                yield "robot", problem
        except HubError as error:
            yield "robot", plain(str(error), lines=True)


def _layout_problems(
    study: StudySpec, spec: ConditionSpec, refused: set[str]
) -> Iterator[tuple[str, str]]:
    from rune_tui.errors import LayoutError
    from rune_tui.startup.opening import open_layout

    try:
        layout = open_layout(layout_of(study, spec), dict(spec.variables))
    except LayoutError as error:
        hint = _own_hint(study, "layouts", spec.layout)
        yield "layout", f"layout {spec.layout!r}: {plain(str(error), lines=True)}{hint}"
        return
    if len(layout.robots) != spec.robots and not refused & {"robots", "layout"}:
        text = (
            f"layout {spec.layout!r} shows {len(layout.robots)} robots, and the condition has "
            f"'robots' = {spec.robots}"
        )
        yield "layout", text
    if not refused & {"layout", "autonomy", "assistance"}:
        yield from layout_problems(spec, layout)


def _own_hint(study: StudySpec, room: str, name: str) -> str:
    """The nearest of the study's own files."""
    return did_you_mean(name, [path.stem for path in (study.folder / room).glob("*")])


def _metrics(draft: StudyDraft) -> Iterator[_Problem]:
    if "metrics" not in draft.sound:
        return
    chosen, place = draft.study.metrics, "[metrics]"
    for key, names in (("primary", chosen.primary), ("secondary", chosen.secondary)):
        for name in names:
            if name not in METRICS:
                text = f"{place}, key '{key}': {name!r} is no metric{did_you_mean(name, METRICS)}"
                yield place, key, text
    if chosen.effectiveness not in EFFECTIVENESS:
        known = " or ".join(EFFECTIVENESS)
        hint = did_you_mean(chosen.effectiveness, EFFECTIVENESS) or f"; write {known}"
        text = f"{place}: {chosen.effectiveness!r} is no effectiveness{hint}"
        yield place, "effectiveness", text


def unmeasured(study: StudySpec) -> Iterator[str]:
    """Metrics that the study chose and that cannot have a value as it is, a sentence each."""
    chosen = study.metrics
    around = {*study.trial.before, *study.trial.after}
    for name in (*chosen.primary, *chosen.secondary):
        asked = _QUESTIONNAIRES.get(name)
        if asked is not None and asked not in around:
            if asked not in study.session.steps:
                yield f"{name} needs the questionnaire {asked!r}, which no step asks"
            elif name in chosen.primary:
                yield (
                    f"{name} is asked once per session, so conditions cannot be compared by it; "
                    f"name {asked!r} in [trial], key 'after'"
                )
        elif name.startswith("sagat_") and study.freeze is None:
            yield f"{name} needs freezes: the table [freeze]"
        elif name in _OF_TASK and study.task is None:
            yield f"{name} needs a secondary task: the table [secondary]"
        elif name == "ft_secondary" and SECONDARY not in study.session.steps:
            yield f"{name} needs the task without a robot: the step `secondary` of [session]"
        elif name.startswith(_OF_VICTIMS) and not all(spec.arena for spec in study.conditions):
            yield f"{name} needs the true arena: the key 'arena' of each condition"
    if chosen.effectiveness == "new_area" and not all(spec.arena for spec in study.conditions):
        yield "the effectiveness 'new_area' needs the true arena; write effectiveness = \"driven\""
