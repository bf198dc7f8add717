"""What the doctor says of the hub of this machine."""

from __future__ import annotations

import socket
import subprocess
import sys
from contextlib import closing
from pathlib import Path

from hub import hub_sockets
from hub.hub_sockets import HubFolder
from hub.inspection.doctor import hub_checks
from hub.inspection.doctor.finding import Level, ok
from hub.ipc.broker.central import Central
from hub.ipc.wire import frames
from tests.hub.inspection.robots import robot

_OTHER_HUB = """
import sys
from hub.ipc.wire import frames
frames.VERSION = 99
from hub.ipc.broker.central import Central
central = Central([sys.argv[1]])
print("up", flush=True)
sys.stdin.read()
central.close()
"""


def test_a_hub_that_runs_and_one_that_does_not_are_well(tmp_path: Path) -> None:
    known = robot(tmp_path)
    assert hub_checks.hub(known) == [ok(f"none of the name {known.name} runs here")]
    assert [said.level for said in hub_checks.kept(known)] == [Level.OK]
    with closing(HubFolder(known.name)) as folder, closing(Central([folder.endpoint])):
        assert hub_checks.hub(known) == [ok(f"{known.name} runs here, with nobody connected")]
        assert hub_checks.kept(known) == [ok("the hub that runs reports no loss")]


def test_a_hub_that_does_not_answer_is_not_well(tmp_path: Path) -> None:
    known = robot(tmp_path)
    with closing(HubFolder(known.name)) as folder, socket.socket(socket.AF_UNIX) as frozen:
        frozen.bind(str(folder.path / hub_sockets.SOCKET))
        frozen.listen()
        (said,) = hub_checks.hub(known)
        (kept,) = hub_checks.kept(known)
    assert (said.level, "does not answer" in said.text) == (Level.PROBLEM, True)
    assert kept.level is Level.UNKNOWN


def test_a_hub_of_another_version_is_named_as_one(tmp_path: Path) -> None:
    known = robot(tmp_path)
    with (
        closing(HubFolder(known.name)) as folder,
        subprocess.Popen(
            [sys.executable, "-c", _OTHER_HUB, folder.endpoint],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        ) as other,
    ):
        assert other.stdout is not None
        assert other.stdin is not None
        assert other.stdout.readline() == b"up\n"
        (said,) = hub_checks.hub(known)
        other.stdin.close()
    assert said.level is Level.PROBLEM
    assert f"another version of Rune (protocol 99, this program {frames.VERSION})" in said.text
    assert "install the same version" in said.advice
