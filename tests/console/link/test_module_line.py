"""The console as a module of a hub: it announces itself, and answers common commands."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.common import COMMON_COMMAND, REQUEST_DATA, CommonCommand, RequestData
from hub.gcm.common import CommonCommandKind as Kind
from hub.gcm.supervision import CAPABILITY_WANTS, MODULE_INFO, CapabilityWants, ModuleInfo
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from rune_tui.layout.spec import CapabilitySpec, RobotSpec
from rune_tui.link.robot_link import RobotLink
from tests.support.waiting import until

WANTED = (CapabilitySpec(name="CON_REAL", interval_s=1.0),)


class Site:
    """A hub without a robot, what consoles announce there, and consoles."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._stack = stack
        self._keys = Keyring(folder / "keys")
        gateway = curve_gateway("tcp://127.0.0.1:0", self._keys)
        central = Central([f"ipc://{folder}/central"], gateways=[gateway])
        self._local, self._far = (stack.enter_context(closing(central)).endpoints)[:2]
        self.client = stack.enter_context(closing(Client("boss", self._local)))
        self.infos: list[ModuleInfo] = []
        self.wants: list[CapabilityWants] = []
        self.client.subscribe(MODULE_INFO, lambda info, _: self.infos.append(info))
        self.client.subscribe(CAPABILITY_WANTS, lambda wants, _: self.wants.append(wants))
        self.client.define(COMMON_COMMAND, REQUEST_DATA)
        self.client.wait_defined(5.0)

    def console(self, role: Role | None = None) -> RobotLink:
        """A console on the robot's machine, or with a key of this role."""
        keys = self._keys.make(role.value, role) if role else None
        endpoint = self._far if role else self._local
        link = RobotLink(RobotSpec(name="robot", hub=endpoint, capabilities=WANTED), keys=keys)
        link.start()
        self._stack.enter_context(closing(link))
        return link

    def until_announced(self, after: int = 0) -> ModuleInfo:
        """The next announcement after so many."""
        until(lambda: self.client.listen(0.05) or len(self.infos) > after, 10.0)
        return self.infos[-1]

    def command(self, kind: Kind, module: str = "", argument: str = "") -> None:
        """Publish a common command."""
        command = CommonCommand(module=module, command=kind, argument=argument)
        self.client.publish(COMMON_COMMAND, command)


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with ExitStack() as stack:
        yield Site(tmp_path, stack)


def test_a_console_announces_itself_as_one_and_at_each_request(site: Site) -> None:
    site.console()
    info = site.until_announced()
    assert (info.pid, info.state, info.capabilities) == (os.getpid(), "running", "CON_REAL")
    assert info.name.startswith("rune-")
    for ask in (
        lambda: site.command(Kind.STATUS, info.name),
        lambda: site.command(Kind.CAPABILITIES),
        lambda: site.client.publish(REQUEST_DATA, RequestData(message=MODULE_INFO.name)),
    ):
        ask()
        site.until_announced(len(site.infos))


def test_a_console_sets_its_log_level_and_leaves_its_end_to_the_operator(site: Site) -> None:
    link = site.console()
    name = site.until_announced().name
    root = logging.getLogger()
    before = root.level
    try:
        site.command(Kind.LOG_LEVEL, "another", "error")
        site.command(Kind.LOG_LEVEL, name, "loud")
        site.command(Kind.LOG_LEVEL, name, "debug")
        until(lambda: site.client.listen(0.05) or root.level == logging.DEBUG, 10.0)
    finally:
        root.setLevel(before)
    site.command(Kind.STOP)
    site.command(Kind.STOP, name)
    until(lambda: site.client.listen(0.05) or bool(link.state.link.refusal), 10.0)
    assert link.state.link.refusal_count == 1
    assert "only its operator ends it" in link.state.link.refusal
    site.until_announced(len(site.infos))


def test_a_console_with_a_key_to_operate_announces_nothing(site: Site) -> None:
    link = site.console(Role.OPERATE)
    until(lambda: site.client.listen(0.05) or len(site.wants) > 1, 10.0)
    assert site.infos == []
    assert link.state.link.refusal == ""
