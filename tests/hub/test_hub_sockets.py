"""Hubs of this machine are found by name, in folders that only their user may enter."""

from __future__ import annotations

import fcntl
import os
import stat
import tempfile
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub import hub_sockets, paths
from hub.errors import EndpointError
from hub.hub_sockets import NOWHERE, HubFolder, address_of
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.endpoints import connectable, endpoint_of, shown
from tests.support.waiting import until


@pytest.fixture(autouse=True)
def alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No other hub is where these tests look."""
    (tmp_path / "run").mkdir(mode=0o700)
    monkeypatch.setenv("RUNE_RUNTIME_DIR", str(tmp_path / "run"))


def running(stack: ExitStack, name: str) -> HubFolder:
    folder = stack.enter_context(closing(HubFolder(name)))
    stack.enter_context(closing(Central([folder.endpoint])))
    return folder


def test_a_hub_is_found_by_its_name_or_as_the_only_one() -> None:
    with ExitStack() as stack:
        assert address_of("hub://") == NOWHERE
        one = running(stack, "magellan")
        assert {
            address_of(f"hub://{name}") for name in ("", "magellan", "?magellan", "?blimp")
        } == {one.endpoint}
        assert address_of("hub://blimp") != one.endpoint  # where that one will be
        other = running(stack, "blimp")
        assert address_of("hub://blimp") == address_of("hub://?blimp") == other.endpoint
        for hub in ("hub://", "hub://?rov"):
            with pytest.raises(EndpointError, match=r"2 hubs run .*\(blimp, magellan\); choose"):
                address_of(hub)
        assert [hub.name for hub in hub_sockets.running()] == ["blimp", "magellan"]
    assert hub_sockets.running() == []


def test_a_second_hub_of_a_name_is_refused_and_a_killed_one_makes_room() -> None:
    with ExitStack() as stack:
        folder = running(stack, "magellan")
        with pytest.raises(EndpointError, match="another name with --as"):
            HubFolder("magellan")
    for name in ("magellan", "rov"):  # they were killed: no process holds their locks
        (folder.path.parent / name).mkdir()
        for file in ("hub", "pid"):
            (folder.path.parent / name / file).touch()
    assert hub_sockets.running() == []
    with closing(HubFolder("magellan")) as again:
        assert [path.name for path in again.path.parent.iterdir()] == ["magellan"]


@pytest.mark.parametrize("where", ["documents", "elsewhere"])
def test_no_file_is_removed_that_no_hub_made(tmp_path: Path, where: str) -> None:
    """`RUNE_RUNTIME_DIR` may be a person's home, with folders that hold files named pid."""
    kept = tmp_path / "run" / where
    kept.mkdir()
    for file in ("pid", "thesis.tex"):
        (kept / file).touch()
    (tmp_path / "run" / "link").symlink_to(kept)
    if where == "documents":
        with pytest.raises(EndpointError, match="documents holds other files"):
            HubFolder("documents")
    else:
        HubFolder("magellan").close()
    assert {each.name for each in kept.iterdir()} == {"pid", "thesis.tex"}


def test_a_hub_that_accepts_no_connection_still_runs_and_looking_makes_none() -> None:
    with ExitStack() as stack:
        folder = stack.enter_context(closing(HubFolder("magellan")))
        central = stack.enter_context(closing(Central([folder.endpoint])))
        for _ in range(20):
            assert [hub.name for hub in hub_sockets.running()] == ["magellan"]
        with closing(Client("one", "hub://magellan")) as client:
            client.wait_connected(10.0)
        assert central.faults.counts == {}
    with closing(HubFolder("blimp")) as busy:
        for _ in range(2):  # before its socket is there, and while nothing listens there
            with pytest.raises(EndpointError, match="runs already"):
                HubFolder("blimp")
            (busy.path / "hub").touch()
        with closing(HubFolder("rov")):
            assert busy.path.exists()


def test_nobody_else_may_enter_its_folder_and_one_of_others_is_not_used() -> None:
    with closing(HubFolder("magellan")) as folder:
        for path in (folder.path, folder.path.parent):
            assert stat.S_IMODE(path.stat().st_mode) == 0o700
    folder.path.parent.chmod(0o755)
    with pytest.raises(EndpointError, match="must belong to this user and have mode 0700"):
        HubFolder("magellan")
    assert hub_sockets.running() == []


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder to another user")
def test_root_uses_no_folder_that_another_user_made(tmp_path: Path) -> None:
    os.chown(tmp_path / "run", 65534, 65534)
    with pytest.raises(EndpointError, match="must belong to this user"):
        HubFolder("magellan")
    other = tmp_path / "run" / "magellan"
    other.mkdir(mode=0o700)
    with (other / "pid").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        (other / "hub").touch()
        assert hub_sockets.running() == []


def test_a_client_finds_a_hub_that_comes_later_and_under_another_path(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    with closing(Client("early", "hub://?magellan")) as client:
        for number in range(2):
            (tmp_path / str(number)).mkdir(mode=0o700)
            monkeypatch.setenv("RUNE_RUNTIME_DIR", str(tmp_path / str(number)))
            with ExitStack() as stack:
                running(stack, "magellan")
                client.wait_connected(10.0)
            until(lambda: not client.connected, 10.0, meanwhile=lambda: client.listen(0.02))


def test_sockets_that_were_removed_are_made_again_while_connections_stay() -> None:
    with (
        closing(HubFolder("magellan")) as folder,
        closing(Central([folder.endpoint])) as central,
        closing(Client("first", "hub://magellan", near=False)) as first,
    ):
        first.wait_connected(10.0)
        number = first.number
        folder.close()
        assert folder.lost()
        assert folder.make_again()
        central.listen_again(folder.endpoint)
        until(lambda: len(list(folder.path.glob("hub*"))) == 7, 10.0)
        with closing(Client("second", "hub://magellan", near=False)) as second:
            second.wait_connected(10.0)
            assert second.directory.listing(10.0).peers
        first.listen(0.1)
        assert (first.connected, first.number) == (True, number)


@pytest.mark.parametrize(
    ("given", "endpoint", "text"),
    [
        ("", "hub://", "this machine"),
        ("127.0.0.1", "hub://", "this machine"),
        ("localhost", "hub://", "this machine"),
        ("magellan", "hub://magellan", "magellan on this machine"),
        ("hub://?rov", "hub://?rov", "this machine"),
        ("ipc:///run/x", "ipc:///run/x", "ipc:///run/x"),
        ("127.0.0.1:1381", "tcp://127.0.0.1:1381", "tcp://127.0.0.1:1381"),
    ],
)
def test_what_an_operator_writes_is_an_endpoint(given: str, endpoint: str, text: str) -> None:
    assert (endpoint_of(given), shown(endpoint)) == (endpoint, text)
    assert connectable(endpoint) == endpoint


@pytest.mark.parametrize("name", ["a/b", "x" * 33, "\x1b"])
def test_what_cannot_be_a_name_is_refused(name: str) -> None:
    with pytest.raises(EndpointError, match="write the name of a robot"):
        connectable(f"hub://{name}")


def test_folders_of_hubs_are_looked_for_where_services_and_logins_have_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("RUNE_RUNTIME_DIR")
    with tempfile.TemporaryDirectory() as short:
        monkeypatch.setenv("XDG_RUNTIME_DIR", short)
        folders = paths.for_hubs()
    assert folders[0] == Path(short) / "rune"
    assert any(folder.name.startswith("rune-") for folder in folders[1:])
