"""Robots for tests of the doctor, read from real files."""

from __future__ import annotations

from pathlib import Path

from hub.robots.description import RobotDescription
from hub.robots.robot_file import read_description

FILE = """name = "magellan"
kind = "simulated-magellan"
{tables}
[modules.driver]
{driver}
"""


def robot_file(folder: Path, tables: str = "", driver: str = 'run = "hub.modules.driver"') -> Path:
    path = folder / "robot.toml"
    path.write_text(FILE.format(tables=tables, driver=driver))
    return path


def robot(folder: Path, tables: str = "", **more: str) -> RobotDescription:
    description, problems = read_description(robot_file(folder, tables, **more))
    assert problems == []
    return description
