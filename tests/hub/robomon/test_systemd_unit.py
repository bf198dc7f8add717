"""The unit that `rune-hub service` writes, judged by systemd itself where there is one."""

from __future__ import annotations

import grp
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.command_line import ExitCode
from hub.robomon.systemd_unit import DEVICE_GROUPS, ServiceSpec, unit
from tests.support.command_line import rune_hub

ROBOT = """name = "{name}"
kind = "simulated-magellan"
[hub]
{hub}
[modules.driver]
run = "hub.modules.driver"
stop_timeout_s = 9.0
nice = -5
[modules.vision]
run = "hub.modules.vision"
"""
SPEC = ServiceSpec(
    robot="magellan",
    robot_file=Path("/etc/rune/magellan.toml"),
    robot_argument="magellan.toml",
    command=("/opt/rune/bin/rune-hub",),
    user="rune",
    groups=(),
    keys=None,
    writable=(),
    gateway=False,
    nice=0,
    stop_timeout=2.0,
)


def written(folder: Path, hub: str, user: str) -> subprocess.CompletedProcess[str]:
    path = folder / "robot file.toml"
    path.write_text(ROBOT.format(name="magellan", hub=hub))
    done = rune_hub("service", str(path), "--user", user)
    assert done.returncode == ExitCode.OK, done.stderr
    return done


def settings(text: str) -> dict[str, str]:
    pairs = [line.partition("=") for line in text.splitlines() if line[:1] not in ("", "#", "[")]
    assert len({name for name, _, _ in pairs}) == len(pairs)
    return {name: value for name, _, value in pairs}


def test_everything_is_filled_in_for_this_machine(tmp_path: Path) -> None:
    done = written(tmp_path, "", "root")
    assert done.stderr == ""
    said = settings(done.stdout)
    program, _, rest = said["ExecStart"].partition(" ")
    assert Path(program.strip('"')).is_file()
    assert rest.endswith(f'run "{tmp_path}/robot file.toml"')
    assert said["User"] == "root"
    assert float(said["TimeoutStopSec"]) > 9.0
    assert said["LimitNICE"] == "-5"
    assert "ReadWritePaths" not in said
    assert said["After"] == "network.target"
    assert "Wants" not in said
    # A group that does not exist keeps systemd from starting the service.
    here = {group.gr_name for group in grp.getgrall()}
    assert set(said.get("SupplementaryGroups", "").split()) == here.intersection(DEVICE_GROUPS)


def test_a_gateway_waits_for_the_network_and_a_missing_user_is_told_of(tmp_path: Path) -> None:
    hub = 'gateway = "tcp://0.0.0.0:1481"\nkeys = "/etc/rune/keys"'
    done = written(tmp_path, hub, "nobody_here")
    assert "useradd --system --create-home nobody_here" in done.stderr
    said = settings(done.stdout)
    assert said["After"] == said["Wants"] == "network-online.target"
    assert said["ReadWritePaths"] == "-/etc/rune/keys"


def test_paths_of_the_robot_file_begin_beside_it(tmp_path: Path) -> None:
    done = written(tmp_path, 'keys = "keys"\nlogs = "logs"', "root")
    assert f"{tmp_path}/keys" in done.stdout
    assert f"{tmp_path}/logs" in done.stdout


@pytest.mark.parametrize("arguments", [["no_such_robot"], ["magellan", "--user", "a\nb"]])
def test_a_mistake_is_a_usage_error_and_no_unit(arguments: list[str]) -> None:
    done = rune_hub("service", *arguments)
    assert (done.returncode, done.stdout) == (ExitCode.USAGE, "")
    assert done.stderr.startswith("rune-hub: ")


@given(st.text(), st.text(), st.text())
def test_no_name_can_add_a_setting(robot: str, file: str, keys: str) -> None:
    plain = unit(replace(SPEC, writable=[Path("/k")]))
    odd_words = {"robot": robot, "robot_argument": file, "robot_file": Path(file)}
    odd = unit(replace(SPEC, **odd_words, keys=Path(keys), writable=[Path(keys)]))  # type: ignore[arg-type]
    # As systemd reads it: a backslash at the end of a line joins the next one to it.
    assert [line.partition("=")[0] for line in odd.split("\n") if line[:1] != "#"] == [
        line.partition("=")[0] for line in plain.split("\n") if line[:1] != "#"
    ]
    assert not any(line.endswith("\\") for line in odd.split("\n"))


ODD = """a "b" 'c' $HOME %i \\x;d"""


def test_words_are_quoted_as_systemd_reads_them() -> None:
    said = settings(unit(replace(SPEC, robot=ODD, robot_file=Path(ODD), writable=[Path(ODD)])))
    quoted = """a \\"b\\" 'c' %s %%%%i \\\\x;d\""""
    assert said["ExecStart"].endswith(f' run "{quoted % "$$HOME"}')
    assert said["ReadWritePaths"] == f'"-{quoted % "$HOME"}'
    assert said["Description"].endswith(""" a "b" 'c' $HOME %%i /x;d""")


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="there is no systemd here")
@pytest.mark.parametrize(
    "spec",
    [
        SPEC,
        replace(
            SPEC,
            writable=[Path("/etc/rune/keys")],
            gateway=True,
            nice=-3,
            groups=("video", "dialout"),
        ),
        replace(
            SPEC, robot=ODD, robot_file=Path(f"/etc/{ODD}"), writable=[Path(f"/etc/{ODD}")] * 2
        ),
    ],
    ids=["plain", "gateway", "odd"],
)
def test_systemd_finds_no_fault(spec: ServiceSpec, tmp_path: Path) -> None:
    file = tmp_path / "rune-hub.service"
    file.write_text(unit(replace(spec, command=(sys.executable, "-m", "hub"))))
    done = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", str(file)],
        capture_output=True,
        text=True,
        check=False,
    )
    ours = [line for line in done.stderr.splitlines() if "rune-hub" in line]
    assert (done.returncode, ours) == (0, [])
