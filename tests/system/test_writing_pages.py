"""The pages on writing parts of one's own: what they show works when it is copied."""

from __future__ import annotations

import re
import subprocess
import sys
from contextlib import closing
from pathlib import Path

from tests.system.test_supervision import Robot, run

DOCS = Path(__file__).parents[2] / "docs"
LONGEST_MODULE = 60


def block(page: str, kind: str, number: int = 0) -> str:
    """A block of code of a page."""
    blocks = re.findall(rf"^```{kind}\n(.*?)^```", (DOCS / page).read_text(), re.DOTALL | re.M)
    return str(blocks[number])


def test_module_of_the_page_runs_when_it_is_wanted_and_answers(tmp_path: Path) -> None:
    program = block("writing-a-module.md", "python")
    assert program.count("\n") < LONGEST_MODULE
    (tmp_path / "compass.py").write_text(program)
    table = block("writing-a-module.md", "toml")
    command = f'command = ["{sys.executable}", "{tmp_path}/compass.py"]'
    table = table.replace('command = ["python3", "compass.py"]', command)
    for name in ("driver", "navigation"):
        table += f'[modules.{name}]\nrun = "hub.modules.{name}"\n'
    with closing(Robot(tmp_path, table)) as robot, subprocess.Popen(
        [sys.executable, "-m", "hub", "want", "X_COMPASS", "--hub", robot.endpoint],
        stdout=subprocess.PIPE, text=True,
    ) as wanting:  # fmt: skip
        assert wanting.stdout is not None
        while "is running" not in (said := wanting.stdout.readline()):
            assert said
        assert said == "X_COMPASS is running: compass\n"
        assert "word: east" in run(robot, "echo", "X_Heading", "-n", "1").stdout
        assert "word: east" in run(robot, "query", "X_Heading_Request").stdout
        wanting.terminate()
