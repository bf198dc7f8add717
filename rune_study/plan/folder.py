"""The folder of a study: where its files stand."""

from __future__ import annotations

from pathlib import Path

from rune_study.errors import QuestionnaireError
from rune_study.plan.study_spec import ConditionSpec, StudySpec
from rune_study.questionnaires.questionnaire import find


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
    # The link shaper carries connections of TCP.
    listen = ["hub.listen=127.0.0.1:0"] if spec.link else []
    return [*first, f"simulation.seed={seed}", *speed, *listen, *spec.settings]


def _existing(path: Path) -> Path | None:
    return path if path.is_file() else None
