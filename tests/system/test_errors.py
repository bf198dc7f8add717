"""What goes wrong is said in a sentence, with the right exit code."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from subprocess import CompletedProcess

import pytest

from tests.support.command_line import run, rune, rune_hub
from tests.system.harness import ConsoleProcess, HubProcess, in_soak


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


def complaint(done: CompletedProcess[str], code: int) -> str:
    """What a command says that ends with this exit code."""
    assert done.returncode == code
    return done.stderr


def test_wrong_layout() -> None:
    path = Path(__file__).with_name("wrong_layout.xml")
    said = complaint(run("rune_tui", "check", str(path)), 2)
    assert f"{path}:4:" in said
    assert "did you mean" in said.lower()


def test_wrong_layout_is_refused_by_run_and_shot_as_well(tmp_path: Path) -> None:
    path = str(Path(__file__).with_name("wrong_layout.xml"))
    assert rune("shot", path, "-o", str(tmp_path / "x.png")).returncode == 2


def test_unknown_option_of_rune_gets_a_hint() -> None:
    said = complaint(rune("shot", "search", "--siez", "80x24", "-o", "x.png"), 2)
    assert said == "rune shot: '--siez' is no option here; did you mean --size?\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("run nowhere.toml", "no such file; give the path of a robot file, or the name of a shi"),
        ("run magelan", "there is no such file; did you mean 'magellan'?"),
        (
            "log-level verbose",
            "it has to be one of debug, info, warning, error; rune-hub log-level",
        ),
        ("completion fish", "it has to be one of bash, zsh, tcsh; rune-hub completion --help says"),
        ("list --hub 127.0.0.1:1 --keys nowhere.toml", "it is not there; copy it again from the"),
        ("mission export --folder /nowhere", "/nowhere cannot be read: No such file"),
    ],
)
def test_wrong_usage_of_rune_hub_is_one_sentence_with_advice(arguments: str, said: str) -> None:
    complained = complaint(rune_hub(*arguments.split()), 2)
    assert said in complained
    assert len(complained.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("terminal", "this needs a terminal; without one, there is nothing to ask"),
        ("joytest", "this needs a terminal; without one, `rune joytest --list` lists what"),
        (
            "shot minimal --offline --seconds 0 --hub 127.0.0.1:1 -o /nowhere/x.png",
            "rune: /nowhere/x.png cannot be written: No such file or directory; choose another",
        ),
    ],
)
def test_wrong_usage_of_rune_is_one_sentence_with_advice(arguments: str, said: str) -> None:
    complained = complaint(rune(*arguments.split()), 2)
    assert said in complained
    assert len(complained.splitlines()) == 1


def test_missing_layout() -> None:
    said = complaint(rune("check", "/nowhere/layout.xml"), 2)
    assert "/nowhere/layout.xml" in said


def test_run_without_a_terminal() -> None:
    said = complaint(rune("run", "demo"), 2)
    assert "terminal" in said


def test_missing_hub(tmp_path: Path) -> None:
    picture = tmp_path / "lost.txt"
    arguments = ("--hub", "127.0.0.1:1", "--seconds", "0.5", "-o", str(picture))
    said = complaint(rune("shot", "minimal", *arguments), 3)
    assert "no hub answered at tcp://127.0.0.1:1, so" in said
    assert not picture.exists()


@pytest.mark.parametrize("command", ["list", *in_soak("modules", "status")])
def test_missing_hub_for_looking_into_it(command: str) -> None:
    said = complaint(rune_hub(command, "--hub", "tcp://127.0.0.1:1"), 3)
    assert said.startswith(
        "rune-hub: no hub answers at tcp://127.0.0.1:1; is rune-hub running there?"
    )
    assert "--keys" in said


def test_hub_elsewhere_is_refused() -> None:
    said = complaint(rune_hub("list", "--hub", "tcp://192.0.2.1:1381"), 2)
    assert "--ssh" in said


def test_name_of_a_hub_that_runs(hub: HubProcess) -> None:
    name = Path(hub.endpoint).parent.name
    said = complaint(run("hub", "run", "magellan", "--as", name), 2)
    assert f"a hub of the name {name} runs already (process {hub.process.pid})" in said


def test_busy_port(tmp_path: Path) -> None:
    with closing(HubProcess(tmp_path, options=("--listen", "0"))) as hub:
        port = hub.listening["tcp"].rpartition(":")[2]
        said = complaint(run("hub", "run", "magellan", "--listen", port), 2)
    assert f":{port}: another program uses it" in said


def test_wrong_robot_file(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text('nam = "x"\n[modules.driver]\nrum = "hub.modules.driver"\n')
    said = complaint(rune_hub("run", str(robot)), 2)
    assert "did you mean 'name'" in said
    assert "did you mean 'run'" in said


def test_unknown_message(hub: HubProcess) -> None:
    said = complaint(rune_hub("echo", "GCM_RobotStat", "--hub", hub.endpoint), 2)
    assert said.endswith("; did you mean 'GCM_RobotState'?\n")


def test_picture_of_an_unknown_kind(tmp_path: Path) -> None:
    said = complaint(rune("shot", "minimal", "-o", str(tmp_path / "x.bmp")), 2)
    assert ".png" in said


@pytest.mark.parametrize(("columns", "rows"), [(20, 5), (1, 1)])
def test_tiny_terminals_show_something_and_quit(
    hub: HubProcess, start_console: Callable[..., ConsoleProcess], columns: int, rows: int
) -> None:
    console = start_console(hub.endpoint, columns=columns, rows=rows)
    if columns >= 10:
        console.wait(lambda: bool(console.text.strip()), 10.0)
    else:
        console.wait(lambda: console.output_bytes > 0, 10.0)
    console.pump(0.5)
    assert console.quit() == 0
