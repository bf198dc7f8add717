"""`rune layout auto` and a hub that has just begun to listen."""

from __future__ import annotations

import threading
from contextlib import closing
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityReports
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from rune_tui.commands.auto import auto_layout
from tests.support.command_line import rune
from tests.support.full_disk import files_no_longer_than
from tests.support.ports import free_port
from tests.support.waiting import until


def test_a_hub_that_does_not_describe_its_robot_yet_is_asked_again() -> None:
    made: list[str] = []
    with closing(Central([f"tcp://127.0.0.1:{free_port()}"])) as central:
        hub = central.endpoints[0]
        asks = threading.Thread(target=lambda: made.append(auto_layout(hub)))
        with closing(Client("robomon", hub)) as daemon:
            daemon.wait_connected(5.0)
            asks.start()
            until(lambda: len(daemon.directory.listing(2.0).peers) > 1, 5.0)
            daemon.listen(0.3)  # it has asked, and there was no answer
            daemon.define(ROBOT_DESCRIPTION, CAPABILITY_REPORTS)
            daemon.publish(ROBOT_DESCRIPTION, RobotBody(name="late", kind="b", radius=0.2))
            daemon.publish(CAPABILITY_REPORTS, CapabilityReports(robot="late", capabilities=()))
            while asks.is_alive():
                daemon.listen(0.02)
    assert "late" in made[0]


def test_a_full_disk_leaves_the_layout_that_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "auto.xml"
    path.write_text("edited")
    monkeypatch.setattr("rune_tui.commands.auto.auto_layout", lambda *_: "<layout/>" * 100)
    with files_no_longer_than(10):
        done = rune("layout", "auto", "-o", str(path))
    assert done.returncode == ExitCode.FAULT
    assert "the output cannot be written" in done.stderr
    assert path.read_text() == "edited"
    assert [*tmp_path.iterdir()] == [path]
