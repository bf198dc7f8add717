"""Values that are given in place of a robot file's."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from hub.errors import RobotFileError
from hub.robomon.module_table import hub_arguments, load_robot_table
from tests.support.cases import for_each


def test_values_stand_in_place_of_the_files_and_every_module_gets_them() -> None:
    settings = ["simulation.arena=empty", "limits.linear=0.3", "simulation.seed=7"]
    robot = load_robot_table("magellan", settings).robot
    assert (robot.arena, robot.linear_limit, robot.seed) == ("empty", 0.3, 7)
    arguments = hub_arguments("ipc:///x", robot)
    given = [b for a, b in itertools.pairwise(arguments) if a == "--set"]
    assert given == settings


@for_each(
    ("setting", "problem"),
    [
        ("arena=empty", "write TABLE.KEY=VALUE"),
        ("simulation.arena", "write TABLE.KEY=VALUE"),
        ("name.first=joe", "write TABLE.KEY=VALUE"),
        ("simulation.arenna=empty", "did you mean 'arena'?"),
        ("limits.linear=fast", "is not a number"),
        ("limits.linear=nan", "is not between"),
    ],
)
def test_a_value_that_cannot_be_is_refused(setting: str, problem: str) -> None:
    with pytest.raises(RobotFileError) as refused:
        load_robot_table("magellan", [setting])
    assert problem in str(refused.value)


def test_an_arena_is_named_by_its_path(tmp_path: Path) -> None:
    arena = tmp_path / "mine.toml"
    source = Path("hub/sim/arenas/empty.toml")
    arena.write_text(source.read_text("utf-8"), "utf-8")
    assert load_robot_table("magellan", [f"simulation.arena={arena}"]).robot.arena == str(arena)
