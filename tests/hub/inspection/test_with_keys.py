"""`rune-hub` commands through a gateway: what is refused is said, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.errors import (
    CentralUnreachableError,
    HandlerFailedError,
    NotAllowedError,
    UnknownModuleError,
)
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.navigation import STOP
from hub.gcm.supervision import MODULE_COMMAND
from hub.inspection import central_commands, message_commands, module_commands
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from tests.hub.ipc.conftest import Peer
from tests.support.waiting import until

Connect = Callable[[Role], Client]


@pytest.fixture
def keyring(tmp_path: Path) -> Keyring:
    return Keyring(tmp_path / "keys")


@pytest.fixture
def central(tmp_path: Path, keyring: Keyring) -> Iterator[Central]:
    gateway = curve_gateway("tcp://127.0.0.1:0", keyring)
    running = Central([f"ipc://{tmp_path}/central"], gateways=[gateway])
    with closing(running):
        yield running


@pytest.fixture
def connect(central: Central, keyring: Keyring) -> Iterator[Connect]:
    """A command's client with a key of the role."""
    with ExitStack() as opened:

        def make(role: Role) -> Client:
            path = keyring.make(f"a-{role.value}", role)
            client = message_commands.connect(central.endpoints[1], f"test-{role.value}", path)
            return opened.enter_context(closing(client))

        yield make


@pytest.mark.parametrize("role", [Role.OBSERVE, Role.OPERATE])
def test_who_may_not_close_modules_is_told_so_at_once(connect: Connect, role: Role) -> None:
    with pytest.raises(NotAllowedError, match=r"may not close modules; do it on the robot"):
        central_commands.close(connect(role), "driver")


def test_who_may_close_modules_is_told_which_there_are_not(connect: Connect) -> None:
    with pytest.raises(UnknownModuleError, match="driver"):
        central_commands.close(connect(Role.MODULE), "driver")


@pytest.mark.parametrize("role", [Role.OBSERVE, Role.OPERATE])
def test_a_log_level_that_was_not_set_is_not_said_to_be(connect: Connect, role: Role) -> None:
    client = connect(role)
    before = client.directory.listing(5.0).level
    other = "error" if before != "error" else "debug"
    with pytest.raises(NotAllowedError, match=rf"logs from {before} on.*do it on the robot"):
        central_commands.log_level(client, other)
    assert client.directory.listing(5.0).level == before


def test_who_has_a_removed_key_is_told_that_it_is_refused(
    central: Central, keyring: Keyring, tmp_path: Path
) -> None:
    copied = tmp_path / "copied.toml"
    keyring.make("gone", Role.OPERATE).rename(copied)
    keyring.remove("gone")
    with pytest.raises(NotAllowedError, match=r"refuses the key 'gone'.*rune-hub keys list"):
        message_commands.connect(central.endpoints[1], "test", copied)


def test_the_key_of_another_hub_is_one_of_the_reasons_given_for_silence(
    central: Central, tmp_path: Path
) -> None:
    other = Keyring(tmp_path / "other").make("one", Role.OPERATE)
    with pytest.raises(CentralUnreachableError, match="was the key made on that robot"):
        message_commands.connect(central.endpoints[1], "test", other)


def sent(client: Client, name: str) -> int:
    return message_commands.send(client, name, [], rate_hz=0.0, zero_first=False)


@pytest.mark.parametrize("role", Role)
def test_every_key_stops_the_robot(
    central: Central, connect: Connect, role: Role, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = Peer("navigation", central.endpoints[0]).connect()
    with closing(robot):
        stops = robot.collect(STOP)
        robot.stands()
        assert sent(connect(role), STOP.name) == 0
        until(lambda: stops, 10.0)
    assert capsys.readouterr().err == ""


def test_who_may_not_send_a_command_is_told_the_least_role_that_may(connect: Connect) -> None:
    observer, operator = connect(Role.OBSERVE), connect(Role.OPERATE)
    with pytest.raises(NotAllowedError, match=r"may not send GCM_Velocity_Command.*role operate$"):
        sent(observer, "GCM_Velocity_Command")
    for client in (observer, operator):
        with pytest.raises(NotAllowedError, match=r"GCM_Common_Command.*--role supervise$"):
            sent(client, "GCM_Common_Command")
        with pytest.raises(NotAllowedError, match="only the robot's module navigation sends"):
            sent(client, "GCM_Drive_Command")


def test_a_stop_that_no_module_takes_asks_for_no_stronger_key(connect: Connect) -> None:
    with pytest.raises(NotAllowedError, match="no module of this robot has defined GCM_Stop yet"):
        sent(connect(Role.OBSERVE), STOP.name)


def test_modules_are_started_and_stopped_by_who_may_supervise(
    central: Central, connect: Connect
) -> None:
    daemon = Peer("robomon", central.endpoints[0]).connect()
    with closing(daemon):
        done = CommonResult(done=1, text="done")
        daemon.call(lambda: daemon.client.respond(MODULE_COMMAND, COMMON_RESULT, lambda _: done))
        daemon.call(lambda: daemon.client.wait_defined(5.0))
        daemon.call(lambda: daemon.client.directory.listing(5.0))
        with pytest.raises(HandlerFailedError, match=r"GCM_Module_Command.*--role supervise$"):
            module_commands.order(connect(Role.OPERATE), "vision", "stop")
        assert module_commands.order(connect(Role.SUPERVISE), "vision", "stop") == 0
