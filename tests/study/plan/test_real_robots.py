"""Whether hubs of real robots fit the conditions of a study."""

from __future__ import annotations

from pathlib import Path

import pytest

from rune_study.plan.checking import check_study
from rune_study.plan.real_robots import RealRobots, real_problems
from tests.study.studies import study_of

TWO = """
[defaults]
layout = "two-robots"
robots = 2
"""


def test_hubs_are_as_many_as_robots(tmp_path: Path) -> None:
    study = study_of(tmp_path, TWO)
    assert real_problems(study, ["tcp://a:1", "tcp://b:1"]) == []
    assert real_problems(study, []) == []
    (problem,) = real_problems(study, ["tcp://a:1"])
    assert problem == "--hub names 1 robots, and conditions have 2"


@pytest.mark.parametrize("line", ["speed = 0.3", 'settings = ["limits.linear=0.3"]'])
def test_what_a_study_cannot_set_on_a_real_robot_is_refused(tmp_path: Path, line: str) -> None:
    study = study_of(tmp_path, f"{TWO}{line}\n")
    (problem,) = real_problems(study, ["tcp://a:1", "tcp://b:1"])
    assert problem.startswith(f"'{line.split(maxsplit=1)[0]}' is for simulated robots")


def test_hubs_of_a_condition_are_checked_and_used_unless_others_are_given(tmp_path: Path) -> None:
    study = study_of(tmp_path, f"{TWO}hubs = ['10.0.0.7', '10.0.0.8:1391']\n")
    assert not check_study(tmp_path).problems
    (spec,) = study.conditions
    assert RealRobots().of(spec).hubs == ("tcp://10.0.0.7:1381", "tcp://10.0.0.8:1391")
    given = RealRobots(hubs=("tcp://a:1", "tcp://b:1"))
    assert given.of(spec) == given
    study_of(tmp_path, f"{TWO}hubs = ['10.0.0.7']\nspeed = 0.3\n")
    problems = " ".join(check_study(tmp_path).problems)
    assert "'hubs' names 1 robots, and 'robots' = 2" in problems
    assert "'speed' is for simulated robots" in problems
