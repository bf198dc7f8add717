"""The pages on writing parts of one's own: what they show works when it is copied."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import subprocess
import sys
import tty
from contextlib import closing
from pathlib import Path

import pytest

from hub.gcm import navigation
from hub.gcm.geometry import TwistStamped
from rune_tui.cli import main
from tests.support.waiting import until
from tests.system.harness import HubProcess
from tests.system.test_supervision import Robot, run

DOCS = Path(__file__).parents[2] / "docs"
LONGEST_PROGRAM = 60
_READY = (navigation.MotionState.STANDING, navigation.MotionState.MOVING)


def block(page: str, kind: str, number: int = 0) -> str:
    """A block of code of a page."""
    blocks = re.findall(rf"^```{kind}\n(.*?)^```", (DOCS / page).read_text(), re.DOTALL | re.M)
    return str(blocks[number])


def test_module_of_the_page_runs_when_it_is_wanted_and_answers(tmp_path: Path) -> None:
    program = block("writing-a-module.md", "python")
    assert program.count("\n") < LONGEST_PROGRAM
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


class Firmware:
    """The other end of the crawler's serial port."""

    def __init__(self) -> None:
        self._ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self.port = os.ttyname(theirs)
        self._theirs = theirs
        self.x = 0.0
        self.velocity = (0.0, 0.0)
        os.set_blocking(self._ours, False)

    def run(self) -> None:
        """Take commands, roll a little, and say so."""
        with contextlib.suppress(BlockingIOError):
            for line in os.read(self._ours, 4096).split(b"\n"):
                words = line.split()
                if len(words) == 3 and words[0] == b"V":
                    self.velocity = float(words[1]), float(words[2])
        self.x += 0.01 * self.velocity[0]
        with contextlib.suppress(BlockingIOError):
            os.write(self._ours, b"S %.3f 0 0 %.2f %.2f 12.4\n" % (self.x, *self.velocity))

    def close(self) -> None:
        os.close(self._ours)
        os.close(self._theirs)


def test_robot_of_the_page_drives_and_stops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "crawler.py").write_text(block("writing-a-robot.md", "python"))
    table = block("writing-a-robot.md", "toml")
    with closing(Firmware()) as firmware:
        monkeypatch.setenv("CRAWLER_PORT", firmware.port)
        (tmp_path / "robot.toml").write_text(table)
        with closing(Robot(tmp_path, table, whole=True)) as robot:
            states: list[navigation.RobotState] = []
            robot.client.subscribe(navigation.ROBOT_STATE, lambda state, _: states.append(state))
            going = [False]

            def drive() -> None:
                # Where this process was away for longer than a stick may be silent, navigation
                # has stopped the robot, and wants a neutral command before it drives on.
                silent = not states or states[-1].motion not in _READY
                if silent or not going[0]:
                    robot.client.publish(navigation.VELOCITY_COMMAND, TwistStamped())
                if going[0]:
                    ahead = TwistStamped.planar(0.9, 0.0)
                    robot.client.publish(navigation.VELOCITY_COMMAND, ahead)
                firmware.run()

            timer = robot.client.every(0.05, drive)
            robot.until(lambda: states and states[-1].motion is navigation.MotionState.STANDING)
            going[0] = True
            robot.until(lambda: firmware.velocity == (0.3, 0.0))
            robot.until(lambda: states[-1].x > 0.01)
            robot.until(lambda: states[-1].battery_voltage == pytest.approx(12.4))
            timer.cancel()
            until(lambda: firmware.velocity == (0.0, 0.0), 5.0, meanwhile=firmware.run)
            # What silent hardware said last is not known to be true now.
            robot.until(lambda: states[-1].motion is navigation.MotionState.NO_DRIVER)


@pytest.mark.parametrize(
    ("page", "name", "seen"),
    [
        ("writing-a-visualizer.md", "compass", " 0°|359°|1°"),
        ("writing-a-widget.md", "turning", "[█▀▄.]{9}"),
    ],
)
def test_extension_of_the_page_fits_its_layout_and_draws(
    page: str, name: str, seen: str, lasting_hub: HubProcess, tmp_path: Path
) -> None:
    program = block(page, "python")
    assert program.count("\n") < LONGEST_PROGRAM
    (tmp_path / f"{name}.py").write_text(program)
    layout, picture = str(tmp_path / f"{name}.xml"), tmp_path / "shot.txt"
    Path(layout).write_text(block(page, "xml"))
    assert main(["check", layout]) == 0

    def drawn() -> bool:
        where = ["--hub", lasting_hub.endpoint, "--size", "40x20", "--seconds", "1"]
        assert main(["shot", layout, *where, "-o", str(picture)]) == 0
        return re.search(seen, picture.read_text()) is not None

    until(drawn, 20.0, picture.read_text)
