"""Studies for tests."""

from __future__ import annotations

import textwrap
from pathlib import Path

from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec

HEAD = 'title = "t"\nseed = "ranges/2026"\nparticipants = 16\n'
FOUR = """
    [factors]
    layout = ["hri-a", "hri-b"]
    link = ["lan", "threshold"]
    [trial]
    seconds = 600
    [freeze]
    count = 3
    not_before_s = 180
    apart_s = 60
    not_after_s = 570
    [secondary]
    [design]
    blind = true
    """
"""A blind study of four conditions with freezes and a secondary task."""


def study_of(folder: Path, text: str) -> StudySpec:
    """The study of a file with this text below its title."""
    (folder / "study.toml").write_text(HEAD + textwrap.dedent(text))
    return read_study(folder)
