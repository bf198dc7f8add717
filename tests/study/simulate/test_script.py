"""What a scripted operator does in a trial is known, and typed answers are those that are meant."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rune_study.data.rows import MetricRow
from rune_study.errors import StudyError
from rune_study.plan.steps import Step
from rune_study.questionnaires.entries import entry_of
from rune_study.questionnaires.items import Answer, Bearing, Item, Pair, PlaceItem
from rune_study.questionnaires.questionnaire import SHIPPED, read
from rune_study.simulate.agreement import findings
from rune_study.simulate.script import IN_REAL_TIME, check_playable, script, write_truth
from rune_study.simulate.typed_answers import ENTER, typed_answer
from tests.study.studies import study_of
from tests.support.full_disk import files_no_longer_than

KEYS = {
    "\x1b[A": "up",
    "\x1b[B": "down",
    "\x1b[C": "right",
    "\x1b[D": "left",
    "\x1b[H": "home",
    "\x7f": "backspace",
    "\r": "enter",
}
ITEMS = [
    item
    for path in sorted(SHIPPED.glob("*.toml"))
    for item in read(path).items
    if not isinstance(item, PlaceItem)  # only freezes have them, which scripts refuse
]


@given(st.integers(0, 1 << 31), st.floats(1.0, 600.0), st.floats(0.1, 10.0), st.integers(1, 4))
@example(seed=12940, seconds=130.0, gap=2.339742785156279, robots=1)  # an episode of 1 s, rounded
def test_pauses_end_episodes_and_all_end_within_the_trial(
    seed: int, seconds: float, gap: float, robots: int
) -> None:
    step = Step(kind="trial", seconds=seconds, seed=seed)
    plan = script(IN_REAL_TIME, step, gap, robots)
    assert plan == script(IN_REAL_TIME, step, gap, robots)
    assert all(each.end - each.begin > 1.0 - 1e-9 for each in plan)
    assert all(after.begin > before.end for before, after in pairwise(plan))
    assert all(gap < each.begin and each.end < seconds and each.end <= each.until for each in plan)
    for robot in range(robots):
        own = [each for each in plan if each.robot == robot]
        assert own == list(plan[robot::robots])
        assert all(after.begin - before.until > gap + 1.0 for before, after in pairwise(own))


@pytest.mark.parametrize("item", ITEMS, ids=lambda item: str(item.id))
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_keys_of_an_answer_give_it_also_after_others(item: Item, seed: int) -> None:
    answer, typed = typed_answer(item, np.random.default_rng(seed))
    assert item.accepts(answer)
    entry = entry_of(item)
    pressed(entry, typed.removesuffix(ENTER))
    assert pressed(entry_of(item), typed) == answer
    assert isinstance(item, Bearing | Pair) or pressed(entry, typed) == answer


def pressed(entry: object, typed: str) -> Answer | None:
    """What an entry makes of typed keys."""
    while typed:
        size = 3 if typed[:3] in KEYS else 1
        key, typed = typed[:size], typed[size:]
        found: Answer | None = entry.press(KEYS.get(key, key), key if len(key) == 1 else None)  # type: ignore[attr-defined]
        if found is not None:
            return found
    return None


def test_what_a_script_cannot_play_is_refused_in_one_sentence(tmp_path: Path) -> None:
    study = study_of(tmp_path, "[freeze]\n[trial]\nends = ['victims']\nseconds = 600\n")
    with pytest.raises(StudyError, match=r"cannot play \[freeze\], ends other than .*; simulate"):
        check_playable(study, most_robots=1)


def test_more_robots_than_a_script_can_serve_are_refused(tmp_path: Path) -> None:
    study = study_of(tmp_path, "[defaults]\nrobots = 3\n")
    check_playable(study, most_robots=3)
    with pytest.raises(StudyError, match="cannot play more than 2 robots; simulate"):
        check_playable(study, most_robots=2)


def test_what_is_asked_once_per_session_has_no_truth() -> None:
    names = ("episodes", "ie_mean", "nt_median", "rad_mission", "fo_measured")
    rows = [
        MetricRow(participant=1, trial=1, code="A", metric=name, value=1.0) for name in names
    ] + [MetricRow(participant=1, trial=0, code="", metric="sus", value=70.0)]
    found = findings([], rows, {}, {(1, 1): 30.0})
    assert [(each.trial, each.metric) for each in found] == [(1, name) for name in names]


def test_a_full_disk_leaves_no_cut_table_of_the_truth(tmp_path: Path) -> None:
    with files_no_longer_than(10), pytest.raises(StudyError, match="cannot be written"):
        write_truth(tmp_path / "truth.csv", [])
    assert [*tmp_path.iterdir()] == []
