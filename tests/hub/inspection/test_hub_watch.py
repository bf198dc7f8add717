"""Commands that run on say that their hub does not answer, and do not end with success."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from hub.command_output import put
from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityPhase, CapabilityReports
from hub.inspection import module_commands
from hub.inspection.hub_watch import HubWatch
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.security.publish_rights import ROBOMON
from tests.console.visualizers.known import capabilities, capability
from tests.hub.ipc.conftest import Peer
from tests.support.waiting import until


@pytest.fixture
def endpoint(tmp_path: Path) -> str:
    return f"ipc://{tmp_path}/central"


def test_the_end_and_the_return_of_a_hub_are_said_once(
    endpoint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(Client("watching", endpoint)) as client:
        with closing(Central([endpoint])):
            client.wait_connected(10.0)
            watch = HubWatch(client)
            watch.listen(0.1)
            assert watch.answers
        until(lambda: not watch.answers, 10.0, meanwhile=lambda: watch.listen(0.05))
        watch.listen(0.1)
        with closing(Central([endpoint])):
            until(lambda: watch.answers, 10.0, meanwhile=lambda: watch.listen(0.05))
    lost, back = capsys.readouterr().err.splitlines()
    assert lost == f"rune-hub: the hub ({endpoint}) does not answer; its state is not known"
    assert back == f"rune-hub: the hub ({endpoint}) answers again"


class Daemon(Peer):
    """Reports that a capability runs."""

    def __init__(self, endpoint: str, reports: CapabilityReports) -> None:
        super().__init__(ROBOMON, endpoint)
        self.connect()
        self.call(lambda: self.client.publish(CAPABILITY_REPORTS, reports))


def test_a_want_whose_hub_went_away_has_not_succeeded(
    endpoint: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = capabilities(capability("VIS_VID", CapabilityPhase.RUNNING, module="vision"))
    central = Central([endpoint])

    def end_after(text: str) -> None:
        put(text)
        central.close()

    monkeypatch.setattr(module_commands, "put", end_after)
    daemon = Daemon(endpoint, runs)
    with closing(Client("wanting", endpoint)) as client:
        client.wait_connected(10.0)
        assert module_commands.want(client, ["VIS_VID"], seconds=4.0) == 1
    daemon.close()
    said = capsys.readouterr()
    assert said.out == "VIS_VID is running: vision\n"
    assert "does not answer" in said.err
