"""The study that comes with Rune is sound, and its report in the docs is the one that it gives.

After a wanted change, write it anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from rune_study.data.store import StudyData
from rune_study.plan.checking import check_study, unmeasured
from rune_study.plan.design_report import design_report
from rune_study.plan.study_file import read_study
from rune_study.report.making import make_page
from rune_study.simulate.model_study import effect_of, simulated
from rune_study.simulate.operator_model import OperatorModel

_ROOT = Path(__file__).parents[2]
_PAGE = _ROOT / "docs" / "fusion-report.html"


def test_the_study_has_all_that_it_names_and_is_balanced() -> None:
    study = read_study(_ROOT / "studies" / "fusion")
    assert check_study(study.folder).problems == []
    assert list(unmeasured(study)) == []
    assert design_report(study).warnings == ()


def test_its_report_is_the_one_in_the_docs() -> None:
    study = read_study(_ROOT / "studies" / "fusion")
    effects = [effect_of("link=threshold:interaction=1.25")]
    trials, metrics = simulated(study, study.participants, OperatorModel(check_s=40.0), effects)
    source = "Models took the place of people; nobody drove a robot."
    data = StudyData(trials=tuple(trials), metrics=tuple(metrics))
    page = make_page(study, data, made="by models", source=source, unblind=True)
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        _PAGE.write_text(page)
    # Last digits of numbers depend on the processor.
    assert _words(page) == _words(_PAGE.read_text())


def _words(page: str) -> str:
    return re.sub(r"[-\d.]+", "0", re.sub(r"<svg.*?</svg>", "", page, flags=re.DOTALL))
