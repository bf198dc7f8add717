"""The folder of a study: where its files stand, and whether what it names can be used."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from hub.errors import HubError
from hub.plain_text import plain
from hub.robots.robot_file import find_robot_file, read_description
from hub.shaper.profile import load_profile
from hub.sim.arena import load_arena
from rune_study.errors import QuestionnaireError
from rune_study.plan.study_spec import ConditionSpec, StudySpec
from rune_study.questionnaires.questionnaire import find, read


def text_path(study: StudySpec, name: str) -> Path | None:
    """The text of this name; None: there is none."""
    return _existing(study.folder / "texts" / f"{name}.md")


def questionnaire_path(study: StudySpec, name: str) -> Path | None:
    """The study's questionnaire of this name, else the one that comes with Rune; None: none."""
    try:
        return find(name, study.folder / "questionnaires")
    except QuestionnaireError:
        return None


def located(study: StudySpec, name: str, room: str, suffix: str) -> str:
    """The path of the study's own file of a name or path; else the name as it is."""
    for own in (study.folder / room / f"{name}{suffix}", study.folder / name):
        if name and own.is_file():
            return str(own.resolve())
    return name


def layout_of(study: StudySpec, spec: ConditionSpec) -> str:
    """Path or name of a condition's layout."""
    return located(study, spec.layout, "layouts", ".xml")


def arena_of(study: StudySpec, spec: ConditionSpec) -> str:
    """Path or name of a condition's arena; empty: that of the robot."""
    return located(study, spec.arena, "arenas", ".toml")


def link_of(study: StudySpec, spec: ConditionSpec) -> str:
    """Path or name of a condition's link profile; empty: the link as it is."""
    return located(study, spec.link, "links", ".toml")


def robot_of(study: StudySpec, spec: ConditionSpec) -> str:
    """Path or name of a condition's robot."""
    return located(study, spec.robot, "robots", ".toml")


def participant_folder(folder: Path, participant: int) -> Path:
    """Folder of a participant's files."""
    return folder / f"sub-{participant:02}"


def hub_settings(study: StudySpec, spec: ConditionSpec, seed: int) -> list[str]:
    """What a condition puts in place of the robot file's values: TABLE.KEY=VALUE."""
    arena = arena_of(study, spec)
    first = [f"simulation.arena={arena}"] if arena else []
    speed = [] if spec.speed is None else [f"limits.linear={spec.speed:g}"]
    return [*first, f"simulation.seed={seed}", *speed, *spec.settings]


def condition_problems(study: StudySpec, spec: ConditionSpec) -> Iterator[str]:
    """Why the parts of a condition cannot be used, a sentence each."""
    from rune_tui.errors import LayoutError
    from rune_tui.startup.opening import open_layout

    try:
        layout = open_layout(layout_of(study, spec), dict(spec.variables))
        if len(layout.robots) != spec.robots:
            yield (
                f"layout {spec.layout!r} shows {len(layout.robots)} robots, and the condition has "
                f"'robots' = {spec.robots}"
            )
    except LayoutError as error:
        yield f"layout {spec.layout!r}: {plain(str(error), lines=True)}"
    try:
        file = find_robot_file(robot_of(study, spec))
        yield from read_description(file, hub_settings(study, spec, seed=1))[1]
        if spec.arena:
            load_arena(arena_of(study, spec))
        if spec.link:
            load_profile(link_of(study, spec))
    except HubError as error:
        yield str(error)


def questionnaire_problems(study: StudySpec, names: Iterable[str]) -> Iterator[str]:
    """Why questionnaires that a study names cannot be used, a sentence each."""
    for path in (questionnaire_path(study, name) for name in names):
        if path is not None:
            try:
                read(path)
            except QuestionnaireError as error:
                yield str(error)


def _existing(path: Path) -> Path | None:
    return path if path.is_file() else None
