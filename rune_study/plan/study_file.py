"""Reads `study.toml` and checks every key; all mistakes are gathered, none stops the reading.

`rune_study.plan.study_spec` declares the keys.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
from collections.abc import Callable, Mapping, Sequence, Set
from pathlib import Path
from typing import Any

from hub import files
from hub import toml_reader as toml
from hub.nearest import did_you_mean
from hub.values import dataclass
from rune_study.errors import StudyError, StudyFileError
from rune_study.lots import room_left
from rune_study.plan.orders import BY_LOT, MOST_OF_ALL
from rune_study.plan.practice import Criterion
from rune_study.plan.study_spec import (
    MOST_CONDITIONS,
    ConditionSpec,
    DesignSpec,
    FreezeSpec,
    LevelSpec,
    MarkersSpec,
    MetricsSpec,
    MomentsSpec,
    PracticeSpec,
    SecondarySpec,
    SessionSpec,
    StudySpec,
    TrialSpec,
    WithholdSpec,
    read_level,
)

STUDY_FILE = "study.toml"
FOLDERS = ("layouts", "arenas", "texts", "questionnaires", "links")
"""Folders of a study whose files its checksum covers."""
_MOST_FILES = 1000
_MOST_BYTES = 16 << 20
_TABLES: Mapping[str, tuple[Callable[..., Any], str, bool]] = {
    "session": (SessionSpec, "session", False),
    "design": (DesignSpec, "design", False),
    "trial": (TrialSpec, "trial", False),
    "practice": (PracticeSpec, "practice", True),
    "freeze": (FreezeSpec, "freeze", True),
    "neglect": (WithholdSpec, "withhold", True),
    "secondary": (SecondarySpec, "task", True),
    "metrics": (MetricsSpec, "metrics", False),
    "markers": (MarkersSpec, "markers", False),
}
"""Tables that occur once: dataclass, field of `StudySpec`, whether it is None without the table."""
_DEFAULTS, _FACTORS, _CONDITION, _LEVEL = "defaults", "factors", "condition", "level"


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyDraft:
    """A study whose file may have mistakes.

    Attributes:
        study: The study, with defaults in place of mistakes, and without its checksum.
        problems: The mistakes, a sentence each.
        sound: Tables without mistakes.
        refused: Keys of conditions that have one.
    """

    study: StudySpec
    problems: toml.Problems
    sound: frozenset[str]
    refused: frozenset[str]


def read_study(folder: Path) -> StudySpec:
    """Read and check the study of a folder.

    Raises:
        StudyFileError: Its file cannot be read, is not TOML, or has mistakes, which are all listed.
    """
    draft = read_draft(folder)
    refuse(folder, draft.problems)
    return dataclasses.replace(draft.study, digest=digest(folder))


def refuse(folder: Path, problems: Sequence[str]) -> None:
    """Raise the problems of a study's file, if there are some.

    Raises:
        StudyFileError: There are.
    """
    if problems:
        raise StudyFileError(str(folder / STUDY_FILE), sorted(problems, key=_line))


def read_draft(folder: Path) -> StudyDraft:
    """Read the study of a folder, and go on after mistakes, to find all of them.

    Raises:
        StudyFileError: Its file cannot be read, or is not TOML.
    """
    data, problems = toml.load(folder / STUDY_FILE, StudyFileError)
    known = [*toml.keys_of(StudySpec), *_TABLES, _DEFAULTS, _FACTORS, _CONDITION, _LEVEL]
    for name in data:
        if name not in known:
            text = f"unknown table or key {toml.shorten(name)}{did_you_mean(name, known)}"
            problems.add(toml.TOP, text, name)
    top = toml.keys_of(StudySpec)
    values = {name: value for name, value in data.items() if name in top}
    fields = toml.read_table(top, values, toml.TOP, problems)
    sound = set()
    for name, (kind, field, optional) in _TABLES.items():
        before = len(problems)
        read = toml.read_table(toml.keys_of(kind), data.get(name, {}), f"[{name}]", problems)
        fields[field] = None if optional and name not in data else kind(**read)
        if len(problems) == before:
            sound.add(name)
    conditions = _Conditions(data, problems)
    fields["conditions"], fields["levels"] = conditions.specs, conditions.levels
    study = StudySpec(**fields, folder=folder, digest="")
    draft = StudyDraft(
        study=study,
        problems=problems,
        sound=frozenset(sound),
        refused=frozenset(conditions.refused),
    )
    _check(draft, conditions.factors)
    return draft


def digest(folder: Path) -> str:
    """SHA-256 of all files of a study that its sessions follow from, in hexadecimal digits.

    Raises:
        StudyError: One cannot be read, or they are too many or too large.
    """
    paths = [folder / STUDY_FILE]
    for name in FOLDERS:
        found = (path for path in (folder / name).rglob("*") if path.is_file())
        paths += itertools.islice(found, _MOST_FILES)
    if len(paths) > _MOST_FILES:
        text = f"{folder} has more than {_MOST_FILES} files of the study; take some out"
        raise StudyError(text)
    whole = hashlib.sha256()
    for path in sorted(paths):
        try:
            content = files.read_regular(path, _MOST_BYTES)
        except (OSError, ValueError) as fault:
            reason = getattr(fault, "strerror", None) or fault
            text = f"{path} cannot be read: {reason}"
            raise StudyError(text) from fault
        whole.update(f"{path.relative_to(folder).as_posix()}\0{len(content)}\0".encode())
        whole.update(content)
    return whole.hexdigest()


def _line(problem: str) -> int:
    line = problem.removeprefix("line ").partition(":")[0]
    return int(line) if problem.startswith("line ") and line.isdigit() else 0


class _Conditions:
    """The conditions of a file: those of [[condition]], or all combinations of [factors].

    Attributes:
        factors: Levels by factor.
        specs: The conditions.
        levels: Of each condition, the levels of its factors.
        refused: Keys that have a mistake.
    """

    def __init__(self, data: Mapping[str, Any], problems: toml.Problems) -> None:
        self._keys = toml.keys_of(ConditionSpec)
        self._problems = problems
        self._defaults = data.get(_DEFAULTS, {})
        toml.read_table(self._keys, self._defaults, f"[{_DEFAULTS}]", problems)
        self.refused: set[str] = set()
        self._places: dict[tuple[str, Any], str] = {}
        self._changes = self._read_levels(data.get(_LEVEL, []))
        self.factors = self._read_factors(data.get(_FACTORS, {}))
        listed = data.get(_CONDITION, [])
        if listed and self.factors:
            problems.add(f"[{_FACTORS}]", "write [factors] or [[condition]], not both")
        self.levels = self._listed(listed) if listed else self._crossed()
        if not 1 <= len(self.levels) <= MOST_CONDITIONS:
            text = f"{len(self.levels)} conditions are not between 1 and {MOST_CONDITIONS}"
            problems.add(f"[{_FACTORS}]", text)
            self.levels = ()
        self.specs = tuple(map(self._spec, self.levels))
        self._check_changes()

    def _read_factors(self, table: object) -> dict[str, tuple[Any, ...]]:
        place = f"[{_FACTORS}]"
        if not isinstance(table, dict):
            self._problems.add(toml.TOP, f"{place}: {toml.shorten(table)} is not a table", _FACTORS)
            return {}
        levels = toml.several(read_level, MOST_CONDITIONS)
        known = [*self._keys, *{factor for factor, _ in self._changes}]
        factors = {}
        for name, value in table.items():
            try:
                factors[name] = levels(value)
            except toml.RefusedError as refused:
                self._problems.add(place, f"{place}, key '{name}': {refused}", name)
                continue
            if name not in known:
                hint = did_you_mean(name, known) or "; a [[level]] says what each level changes"
                self._problems.add(place, f"{place}: unknown factor {name!r}{hint}", name)
            elif len(set(factors[name])) < len(factors[name]):
                self._problems.add(place, f"{place}, key '{name}': a level comes twice", name)
            elif name in self._keys:
                for level in factors[name]:
                    self._try(name, level, place)
        return factors

    def _try(self, name: str, value: object, place: str) -> None:
        try:
            self._keys[name].read(value)
        except toml.RefusedError as refused:
            self._problems.add(place, f"{place}, key '{name}': {refused}", name)

    def _read_levels(self, tables: object) -> dict[tuple[str, Any], LevelSpec]:
        if not isinstance(tables, list):
            text = f"{_LEVEL} has to be a list of tables: [[{_LEVEL}]]"
            self._problems.add(toml.TOP, text, _LEVEL)
            return {}
        found = {}
        for count, table in enumerate(tables, 1):
            before, place = len(self._problems), toml.repeated(_LEVEL, count)
            fields = toml.read_table(toml.keys_of(LevelSpec), table, place, self._problems)
            if len(self._problems) == before:
                which = fields["factor"], fields["level"]
                found[which], self._places[which] = LevelSpec(**fields), place
        return found

    def _check_changes(self) -> None:
        """Find levels that no condition has."""
        used = set().union(*(levels.items() for levels in map(_comparable, self.levels)))
        for (factor, level), place in self._places.items():
            known = any(factor in levels for levels in self.levels)
            if (factor, level) not in used and (known or not self._problems):
                own = [str(each) for name, each in used if name == factor]
                hint = did_you_mean(str(level), own)
                text = f"{place}: no condition has {factor} = {toml.shorten(level)}{hint}"
                self._problems.add(place, text, "level")

    def _crossed(self) -> tuple[dict[str, Any], ...]:
        combined = itertools.product(*self.factors.values())
        kept = itertools.islice(combined, MOST_CONDITIONS + 1)
        return tuple(dict(zip(self.factors, levels, strict=True)) for levels in kept)

    def _listed(self, tables: object) -> tuple[dict[str, Any], ...]:
        if not isinstance(tables, list):
            text = f"{_CONDITION} has to be a list of tables: [[{_CONDITION}]]"
            self._problems.add(toml.TOP, text, _CONDITION)
            return ()
        for count, table in enumerate(tables, 1):
            place = toml.repeated(_CONDITION, count)
            toml.read_table(self._keys, table, place, self._problems)
        return tuple(dict(table) for table in tables if isinstance(table, dict))

    def _spec(self, levels: Mapping[str, Any]) -> ConditionSpec:
        """The condition of these levels; a mistake, which is known already, becomes the default."""
        own = {name: value for name, value in levels.items() if name in self._keys}
        defaults = self._defaults if isinstance(self._defaults, dict) else {}
        given = {**defaults, **own}
        for name in [name for name in given if name in self._keys]:
            try:
                self._keys[name].read(given[name])
            except toml.RefusedError:
                self.refused.add(name)
        fields = toml.read_table(self._keys, given, "", toml.Problems())
        for each in _comparable(levels).items():
            change = self._changes.get(each)
            if change is not None:
                fields["variables"] = (*fields["variables"], *change.variables)
                fields["settings"] = (*fields["settings"], *change.settings)
        return ConditionSpec(**fields)


def _comparable(levels: Mapping[str, Any]) -> dict[str, Any]:
    """Those levels that can be compared."""
    return {name: each for name, each in levels.items() if isinstance(each, str | float | int)}


def _check(draft: StudyDraft, factors: Mapping[str, Any]) -> None:
    """Add what is wrong although each key is right; tables with mistakes are left out."""
    study, sound, problems = draft.study, draft.sound, draft.problems
    if "design" in sound:
        _check_design(study, factors, problems)
    if "session" in sound:
        _check_session(study, problems)
    if "trial" in sound:
        _check_moments(study, sound, problems)
    if study.task is not None and "secondary" in sound:
        _check_task(study.task, problems)
    if study.practice is not None and study.practice.criterion:
        try:
            Criterion.read(study.practice.criterion)
        except StudyError as error:
            problems.add("[practice]", f"[practice], key 'criterion': {error}", "criterion")


def _check_design(study: StudySpec, factors: Mapping[str, Any], problems: toml.Problems) -> None:
    design = study.design
    if design.order == "all" and len(study.conditions) > MOST_OF_ALL:
        text = f"[design]: 'all' has at most {MOST_OF_ALL} conditions; use 'williams' or 'random'"
        problems.add("[design]", text, "order")
    if design.order not in BY_LOT and (design.longest_run or design.apart):
        text = "[design]: 'longest_run' and 'apart' need the order 'random' or 'blocks'"
        problems.add("[design]", text, "order")
    known = factors or set().union(*study.levels)
    for name in design.apart:
        if name not in known:
            text = f"[design], key 'apart': {name!r} is no factor{did_you_mean(name, known)}"
            problems.add("[design]", text, "apart")


def _check_session(study: StudySpec, problems: toml.Problems) -> None:
    session = study.session
    if session.steps.count("trials") != 1:
        problems.add("[session]", "[session]: 'steps' has to name `trials` once", "steps")
    if "practice" in session.steps and study.practice is None:
        problems.add(
            "[session]", "[session]: the step `practice` needs the table [practice]", "steps"
        )
    if "secondary" in session.steps and study.task is None:
        problems.add(
            "[session]", "[session]: the step `secondary` needs the table [secondary]", "steps"
        )


def _check_moments(study: StudySpec, sound: Set[str], problems: toml.Problems) -> None:
    parts: tuple[tuple[str, MomentsSpec | None], ...]
    parts = (("freeze", study.freeze), ("neglect", study.withhold))
    for name, spec in parts:
        if spec is None or name not in sound:
            continue
        place = f"[{name}]"
        if spec.not_after_s is not None and spec.not_after_s > study.trial.seconds:
            text = (
                f"{place}, key 'not_after_s': {spec.not_after_s:g} s is after the end of a trial, "
                f"which is at {study.trial.seconds:g} s ('seconds' of [trial])"
            )
            problems.add(place, text, "not_after_s")
        last = latest(spec, study.trial)
        if room_left(spec.count, spec.not_before_s, last, spec.apart_s) < 0.0:
            text = (
                f"{place}: {spec.count} moments, {spec.apart_s:g} s apart, do not fit between "
                f"{spec.not_before_s:g} s and {last:g} s"
            )
            problems.add(place, text, "count")


def _check_task(task: SecondarySpec, problems: toml.Problems) -> None:
    place = "[secondary]"
    if len(task.right) != len(task.ask):
        text = f"{place}: {len(task.ask)} texts of 'ask' have {len(task.right)} keys of 'right'"
        problems.add(place, text, "right")
    for name in task.right:
        if name not in task.keys:
            text = (
                f"{place}, key 'right': {name!r} is none of 'keys'{did_you_mean(name, task.keys)}"
            )
            problems.add(place, text, "right")


def latest(spec: MomentsSpec, trial: TrialSpec) -> float:
    """Latest moment of a trial at which something of this kind begins [s]."""
    return trial.seconds if spec.not_after_s is None else min(spec.not_after_s, trial.seconds)
