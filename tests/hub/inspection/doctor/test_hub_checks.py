"""What the doctor says of the hub of this machine."""

from __future__ import annotations

import socket
from contextlib import closing
from pathlib import Path

from hub import hub_sockets
from hub.hub_sockets import HubFolder
from hub.inspection.doctor import hub_checks
from hub.inspection.doctor.finding import Level, ok
from hub.ipc.broker.central import Central
from tests.hub.inspection.robots import robot


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
