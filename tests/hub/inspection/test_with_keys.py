"""`rune-hub` commands through a gateway: what is refused is said, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.errors import CentralUnreachableError, NotAllowedError, UnknownModuleError
from hub.inspection import commands, status
from hub.ipc.central import Central
from hub.ipc.client import Client
from hub.ipc.keyring import Keyring
from hub.ipc.security import Role

Connect = Callable[[Role], Client]


@pytest.fixture
def keyring(tmp_path: Path) -> Keyring:
    return Keyring(tmp_path / "keys")


@pytest.fixture
def central(tmp_path: Path, keyring: Keyring) -> Iterator[Central]:
    gateway = "tcp://127.0.0.1:0"
    running = Central([f"ipc://{tmp_path}/central"], gateway=gateway, keyring=keyring)
    with closing(running):
        yield running


@pytest.fixture
def connect(central: Central, keyring: Keyring) -> Iterator[Connect]:
    """A command's client with a key of the role."""
    with ExitStack() as opened:

        def make(role: Role) -> Client:
            path = keyring.make(f"a-{role.value}", role)
            client = commands.connect(central.endpoints[1], "test", path)
            return opened.enter_context(closing(client))

        yield make


@pytest.mark.parametrize("role", [Role.OBSERVE, Role.OPERATE])
def test_who_may_not_close_modules_is_told_so_at_once(connect: Connect, role: Role) -> None:
    with pytest.raises(NotAllowedError, match=r"may not close modules.*--role module"):
        status.close(connect(role), "driver")


def test_who_may_close_modules_is_told_which_there_are_not(connect: Connect) -> None:
    with pytest.raises(UnknownModuleError, match="driver"):
        status.close(connect(Role.MODULE), "driver")


@pytest.mark.parametrize("role", [Role.OBSERVE, Role.OPERATE])
def test_a_log_level_that_was_not_set_is_not_said_to_be(connect: Connect, role: Role) -> None:
    client = connect(role)
    before = client.directory.listing(5.0).level
    other = "error" if before != "error" else "debug"
    with pytest.raises(NotAllowedError, match=rf"logs from {before} on.*--role module"):
        status.log_level(client, other)
    assert client.directory.listing(5.0).level == before


def test_who_has_a_removed_key_is_told_that_it_is_refused(
    central: Central, keyring: Keyring, tmp_path: Path
) -> None:
    copied = tmp_path / "copied.toml"
    keyring.make("gone", Role.OPERATE).rename(copied)
    keyring.remove("gone")
    with pytest.raises(NotAllowedError, match=r"refuses the key 'gone'.*rune-hub keys list"):
        commands.connect(central.endpoints[1], "test", copied)


def test_the_key_of_another_hub_is_one_of_the_reasons_given_for_silence(
    central: Central, tmp_path: Path
) -> None:
    other = Keyring(tmp_path / "other").make("one", Role.OPERATE)
    with pytest.raises(CentralUnreachableError, match="was the key made on that robot"):
        commands.connect(central.endpoints[1], "test", other)
