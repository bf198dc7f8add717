"""`rune-hub query`: what it shows, and how it ends."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.mapping import MAP_COMMAND, MapCommand
from hub.inspection import message_commands
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from tests.hub.ipc.conftest import Peer


def answered(command: MapCommand) -> CommonResult:
    if command.name == "office":
        return CommonResult(done=1, text="saved office")
    return CommonResult(done=0, text="there is no map\nof that name")


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    """A command's client at a central where somebody tends maps."""
    with closing(Central([f"ipc://{tmp_path}/central"])) as central:
        mapping = Peer("mapping", central.endpoints[0]).connect()
        mapping.call(lambda: mapping.client.respond(MAP_COMMAND, COMMON_RESULT, answered))
        with closing(message_commands.connect(central.endpoints[0], "query", None)) as connected:
            yield connected
        mapping.close()


def ask(client: Client, name: str, *, as_json: bool = False) -> int:
    fields = ["order=LOAD", f"name={name}"]
    return message_commands.query(client, MAP_COMMAND.name, fields, timeout=5.0, as_json=as_json)


def test_what_is_done_is_shown(client: Client, capsys: pytest.CaptureFixture[str]) -> None:
    assert ask(client, "office") == 0
    said = capsys.readouterr()
    assert (said.out, said.err) == ("done: 1\ntext: saved office\n", "")


def test_what_cannot_be_done_is_shown_and_complained_of(
    client: Client, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ask(client, "nowhere", as_json=True) == 1
    said = capsys.readouterr()
    assert json.loads(said.out)["done"] == 0
    assert said.err == "rune-hub: there is no map\\nof that name\n"
