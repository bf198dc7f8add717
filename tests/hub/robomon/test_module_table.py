"""Robot files: what they say, and every mistake at once."""

from __future__ import annotations

import contextlib
import math
import os
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hub.errors import RobotFileError
from hub.robomon.module_table import load_robot_table
from hub.robots import description
from hub.robots.robot_file import SHIPPED

GOOD = (SHIPPED / "magellan.toml").read_text()


def problems_of(folder: Path, text: str) -> list[str]:
    path = folder / "robot.toml"
    path.write_text(text)
    with pytest.raises(RobotFileError) as caught:
        load_robot_table(str(path))
    assert all(line.startswith(f"{path}:") for line in str(caught.value).splitlines())
    return list(caught.value.problems)


def test_shipped_robot_has_all_modules() -> None:
    table = load_robot_table("magellan")
    assert [module.name for module in table.modules] == [
        "driver",
        "navigation",
        "vision",
        "mapping",
        "autonomy",
        "recorder",
    ]
    assert table.robot.listen == ""
    assert table.robot.linear_limit == 0.5


def test_arena_of_one_s_own_lies_beside_the_robot_file(tmp_path: Path) -> None:
    import hub.sim

    shipped = Path(hub.sim.__file__).parent / "arenas" / "empty.toml"
    (tmp_path / "mine.toml").write_text(shipped.read_text())
    robot = tmp_path / "robot.toml"
    robot.write_text(GOOD.replace('arena = "yellow"', 'arena = "mine.toml"'))
    assert load_robot_table(str(robot)).robot.arena == str(tmp_path / "mine.toml")


def test_camera_of_one_s_own_is_named_beside_the_robot_file(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"

    def source(line: str) -> str:
        robot.write_text(f"{GOOD}[camera]\n{line}\n")
        return load_robot_table(str(robot)).robot.camera.source

    assert source("") == "robot"
    assert source('source = "drive.mp4"') == str(tmp_path / "drive.mp4")
    assert source('source = "/dev/video0"') == "/dev/video0"
    assert source('source = "rtsp://10.0.0.7/x"') == "rtsp://10.0.0.7/x"
    source("fov_deg = 90")
    assert load_robot_table(str(robot)).robot.camera.fov == pytest.approx(math.pi / 2)


def test_when_exploring_ends_is_set_in_the_robot_file_and_told_to_who_asks(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text(
        GOOD + "\n[autonomy]\nnothing_new_s = 90\nnothing_new_share = 0.05\nlongest_s = 900\n"
    )
    table = load_robot_table(str(robot))
    assert (table.robot.nothing_new_s, table.robot.nothing_new_share) == (90.0, 0.05)
    assert table.robot.longest_exploring_s == 900.0
    new = f"nothing_new_s ({description.NOTHING_NEW_S:g}): "
    for setting in (new, "nothing_new_share (0.02): ", "longest_s (600): "):
        assert setting in description.settings("autonomy")
    assert not description.settings("vision")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "seed = 1 ",
            "light = 2\nseed = 1 ",
            "[simulation], key 'light': 2 is not between 0 and 1",
        ),
        (
            "[simulation]",
            '[camera]\nsource = "ftp://x"\n[simulation]',
            "[camera], key 'source': no pictures can be had from ftp://x",
        ),
        (
            "[simulation]",
            "[camera]\nfov_deg = 180\n[simulation]",
            "[camera], key 'fov_deg': 180 is not between 1 and 170",
        ),
        ('name = "magellan"\n', "", "top of the file: key 'name' is missing"),
        ('"simulated-magellan"', '"simulated-magelan"', "did you mean 'simulated-magellan'?"),
        ("linear = 0.5", "linaer = 0.5", "[limits]: unknown key 'linaer'; did you mean 'linear'?"),
        ("linear = 0.5", 'linear = "fast"', "[limits], key 'linear': 'fast' is not a number"),
        ("linear = 0.5", "linear = nan", "[limits], key 'linear': nan is not between"),
        ('arena = "yellow"', 'arena = "yelow"', "yellow"),
        ("seed = 1 ", "seed = 1.5 ", "1.5 is not a whole number"),
        ('run = "hub.modules.vision"', "", "[modules.vision]: give either 'run'"),
        ("hub.modules.vision", "hub.modules.sight", "no Python module 'hub.modules.sight'"),
        ("[modules.vision]", "[[modules.vision]]", "[modules.vision]: "),
        ("[simulation]", "[simulator]", "unknown key 'simulator'; did you mean 'simulation'?"),
    ],
)
def test_a_mistake_is_named_with_its_place(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in GOOD
    assert any(said in problem for problem in problems_of(tmp_path, GOOD.replace(old, new)))


AUTOPILOT = """
name = "rover"
kind = "mavlink"
[mavlink]
address = "tcp://127.0.0.1:5760"
[body]
arming = "disarmed"
[modules.driver]
run = "hub.modules.driver"
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("tcp://127.0.0.1:5760", "tcp://127.0.0.1", "line 5: [mavlink], key 'address': 'tcp://"),
        ('address = "tcp://127.0.0.1:5760"', "", "line 4: [mavlink], key 'address': it is missing"),
        (
            "tcp:",
            "http:",
            "line 5: [mavlink], key 'address': 'http://127.0.0.1:5760' is no address",
        ),
        ('"disarmed"', '"armed"', "line 7: [body], key 'arming': an autopilot is armed by an"),
        ('arming = "disarmed"', "", "line 6: [body], key 'arming': an autopilot is armed by an"),
        ("[modules.driver]", "[[hold]]\nkind='depth'\n[modules.driver]", "line 8: [[hold]] 1, key"),
        (
            "[modules.driver]",
            "[[light]]\nname='a'\n[[light]]\nname='b'\n[[light]]\nname='c'\n[modules.driver]",
            "line 13: [[light]] 3, key 'name': the kind 'mavlink' has two only",
        ),
        ("[body]", "station = 0\n[body]", "line 6: [mavlink], key 'station': 0 is not between 1"),
    ],
)
def test_mistakes_of_a_robot_with_an_autopilot_have_their_lines(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    path = tmp_path / "good.toml"
    path.write_text(AUTOPILOT)
    assert load_robot_table(str(path)).robot.vehicle_address == "tcp://127.0.0.1:5760"
    found = problems_of(tmp_path, AUTOPILOT.replace(old, new))
    assert len(found) == 1
    assert found[0].startswith(said)


def test_a_table_that_nobody_knows_has_its_line(tmp_path: Path) -> None:
    line = GOOD.splitlines().index("[simulation]") + 1
    text = GOOD.replace("[simulation]", "[simulator]")
    said = f"line {line}: top of the file: unknown key 'simulator'"
    assert any(problem.startswith(said) for problem in problems_of(tmp_path, text))


def test_all_mistakes_are_reported_at_once(tmp_path: Path) -> None:
    text = GOOD.replace('"yellow"', "5").replace("seed", "sead").replace("0.5", "500")
    assert len(problems_of(tmp_path, text)) == 3


def test_a_number_of_thousands_of_digits_is_no_way_out(tmp_path: Path) -> None:
    text = GOOD.replace("seed = 1 ", "seed = 0x" + "f" * 5000 + " ")
    (said,) = problems_of(tmp_path, text)
    assert said.startswith("line 11: [simulation], key 'seed': a number of many digits is not")


def test_not_toml_and_no_file(tmp_path: Path) -> None:
    assert "is not TOML" in problems_of(tmp_path, "name = ")[0]
    with pytest.raises(RobotFileError, match="did you mean 'magellan'"):
        load_robot_table("magelan")
    with pytest.raises(RobotFileError, match="no regular file"):
        load_robot_table(str(tmp_path))


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "robot.toml")
    with pytest.raises(RobotFileError, match="no regular file"):
        load_robot_table(str(tmp_path / "robot.toml"))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_no_bytes_raise_anything_but_our_error(tmp_path: Path, data: st.DataObject) -> None:
    raw = bytearray(GOOD.encode())
    for _ in range(data.draw(st.integers(1, 6))):
        raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / "robot.toml"
    path.write_bytes(raw)
    with contextlib.suppress(RobotFileError):
        load_robot_table(str(path))


@pytest.mark.parametrize(
    "name", ["..", "-x", ".hidden", "a/b", "two words", "\x1b]0;x\x07", "", "x" * 33, "\u202ebot"]
)
def test_robot_is_called_what_a_file_can_be_called(tmp_path: Path, name: str) -> None:
    escaped = name.encode("unicode_escape").decode().replace("\\x", "\\u00")
    problems = problems_of(tmp_path, GOOD.replace('"magellan"', f'"{escaped}"', 1))
    assert len(problems) == 1
    assert "key 'name'" in problems[0]
    assert problems[0].isprintable()


def test_control_characters_of_a_robot_file_do_not_reach_the_terminal(tmp_path: Path) -> None:
    evil = "\\u001b]0;x\\u0007"
    problems = problems_of(
        tmp_path,
        f'{GOOD}\n[modules."{evil}"]\nrun = "hub.modules.driver"\n[camera]\nsource = "{evil}"\n'
        f'[mapping]\nfolder = "{evil}"\n["{evil}"]\n',
    )
    assert len(problems) >= 4
    assert all(each.isprintable() for each in problems)


@pytest.mark.parametrize(
    "text",
    [
        "a" + ".a" * 100_000 + " = 1",
        "[a" + ".a" * 100_000 + "]",
        "[[a" + " . a" * 50_000 + "]]",
        'x = {"b"' + ".'c'" * 50_000 + " = 1}",
        "a" * 900_000 + " = 1",
        'x = """\n' + ("[" + " " * 900 + "\n") * 900 + '"""',
        '"' * 3 + '"\\n' * 100,
    ],
    ids=["key", "header", "array", "inline", "long", "blanks", "quotes"],
)
def test_no_text_keeps_the_reader_busy(tmp_path: Path, text: str) -> None:
    """The parser of Python takes minutes for the first ones."""
    began = time.process_time()
    problems = problems_of(tmp_path, text)
    assert problems
    assert time.process_time() - began < 5.0
    if "." in text:  # else there is no long key
        assert "a key has more than 16 parts" in problems[0]


@pytest.mark.parametrize(
    ("kind", "tables", "problem"),
    [
        ("wheels", "[limits]\nheave = 0.3\n", ":4: [limits], key 'heave': a simulated body"),
        ("wheels", '[safety]\nleft_alone = "surface"\n', ":4: [safety], key 'left_alone'"),
        (
            "wheels",
            '[limits]\nsway = 0.3\n[simulation]\narena = "red"\n',
            "[limits], key 'sway': a simulated body of this kind cannot sway on rough ground",
        ),
        ("tracked", "[limits]\nsway = 0.3\n", "of this kind cannot sway"),
        ("wheels", "[body]\nradius = 5.0\n", "the robot would touch wall 1 at the start"),
        ("blimp", "[limits]\nsway = 0.3\n", "of this kind cannot sway"),
        (
            "blimp",
            '[[range]]\nname = "a"\nkind = "sonar"\nfarthest = 2\n',
            ":4: [[range]] 1, key 'name'",
        ),
        ("wheels", "[limits]\nsway = 0.3\nlinear = 0\nangular = 0\n", ""),
    ],
)
def test_a_simulated_body_is_not_asked_for_what_it_cannot_do(
    tmp_path: Path, kind: str, tables: str, problem: str
) -> None:
    path = tmp_path / "robot.toml"
    module = '[modules.driver]\nrun = "hub.modules.driver"\n'
    path.write_text(f'name = "a"\nkind = "simulated-{kind}"\n{tables}{module}')
    if not problem:
        load_robot_table(str(path))
        return
    with pytest.raises(RobotFileError) as refused:
        load_robot_table(str(path))
    assert problem in str(refused.value)
