"""The first files of a study, to be edited."""

from __future__ import annotations

from pathlib import Path

from hub.files import replace
from rune_study.errors import StudyError
from rune_study.plan.study_file import STUDY_FILE

TEMPLATE = Path(__file__).parent / "template"
"""Folder of a study with two conditions."""


def write_study(folder: Path) -> list[Path]:
    """Write the files of a study of two conditions.

    Raises:
        StudyError: There is a study, or they cannot be written.
    """
    if (folder / STUDY_FILE).exists():
        text = f"{folder} has a {STUDY_FILE} already; name another folder"
        raise StudyError(text)
    written = []
    try:
        for path in sorted(each for each in TEMPLATE.rglob("*") if each.is_file()):
            to = folder / path.relative_to(TEMPLATE)
            to.parent.mkdir(parents=True, exist_ok=True)
            content = path.read_text("utf-8").replace("SEED", folder.resolve().name or "study")
            replace(to, content.encode())
            written.append(to)
    except OSError as fault:
        text = f"{fault.filename} cannot be written: {fault.strerror}; name another folder"
        raise StudyError(text) from fault
    return written
