"""Each shipped robot has a page, with its body as `rune-hub check` shows it.

After a wanted change, write them anew:
RUNE_WRITE_SNAPSHOTS=1 pytest tests/house/test_robot_pages.py
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from hub.inspection import check_command
from hub.robots.robot_file import SHIPPED, read_description

_PAGES = Path(__file__).parents[2] / "docs" / "robots"
_NAMES = sorted(path.stem for path in SHIPPED.glob("*.toml"))


def test_each_shipped_robot_has_a_page() -> None:
    assert sorted(path.stem for path in _PAGES.glob("*.md")) == _NAMES
    index = (_PAGES.parent / "robots.md").read_text()
    assert [name for name in _NAMES if f"(robots/{name}.md)" not in index] == []


@pytest.mark.parametrize("name", _NAMES)
def test_body_on_a_page_is_the_shipped_one(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = _PAGES / f"{name}.md"
    robot, _ = read_description(SHIPPED / f"{name}.toml")
    check_command.check(robot, as_json=False)
    shown = capsys.readouterr().out.split("\n", 1)[1]
    block = re.compile(
        rf"(rune-hub check {name}\n```\n\n```\n)(.*?)(^```)", re.DOTALL | re.MULTILINE
    )
    wanted, found = block.subn(lambda place: place[1] + shown + place[3], path.read_text())
    assert found == 1
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        path.write_text(wanted)
    assert path.read_text() == wanted, "write the pages anew, as this file's docstring says"
