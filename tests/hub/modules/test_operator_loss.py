"""A robot file that wants more than the hardware can do is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.errors import RobotFileError
from hub.modules.driver.operator_loss import OperatorLoss
from hub.robots.description import RobotDescription
from hub.robots.registry import kind_of
from hub.robots.robot_file import read_description


def robot(folder: Path, action: str) -> RobotDescription:
    file = folder / "robot.toml"
    head = 'name = "magellan"\nkind = "simulated-magellan"\n'
    file.write_text(f'{head}[safety]\nleft_alone = "{action}"\n')
    read, problems = read_description(file)
    assert not problems
    return read


def test_a_robot_that_rolls_stands_but_cannot_surface(tmp_path: Path) -> None:
    rolls = robot(tmp_path, "stand")
    OperatorLoss(kind_of(rolls).open_body(rolls), rolls).update(0.0)
    dives = robot(tmp_path, "surface")
    with pytest.raises(RobotFileError, match="the kind 'simulated-magellan' can only stand"):
        OperatorLoss(kind_of(dives).open_body(dives), dives)
