"""What a gamepad at another machine says, through a real central, to the console's link."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest

from hub.errors import NotAllowedError
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.pad import (
    CONSOLE_HZ,
    MESSAGES,
    PAD_CONSOLE,
    PAD_DEVICE,
    PAD_STATE,
    PadConsole,
    PadState,
)
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.keyring import Keyring
from rune_tui.controls.devices.device_reader import Scanned
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.robot_links import RobotLinks
from rune_tui.startup.opening import open_layout
from tests.console.controls.remote_pad.test_far_pads import CONTROLS, told_device
from tests.support.waiting import until

JOYSTICK = '<joystick name="pad"/>'


class Hub:
    """A hub that lets others in, and consoles at it."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._folder, self._stack = folder, stack
        self._keyring = Keyring(folder / "keys")
        gateway = curve_gateway("tcp://127.0.0.1:0", self._keyring)
        self.central = Central([f"ipc://{folder}/c"], gateways=[gateway])
        stack.enter_context(closing(self.central))

    def layout(self, inner: str) -> LayoutSpec:
        path = self._folder / "layout.xml"
        robot = f'<robot name="magellan" hub="{self.central.endpoints[0]}"/>'
        path.write_text(f'<rune>{robot}{inner}<view xsize="9" ysize="9"/></rune>')
        return open_layout(path)

    def console(self, inner: str = JOYSTICK, role: Role | None = None) -> RobotLinks:
        keys = self._keyring.make("console", role) if role else None
        hubs = [self.central.endpoints[1]] if role else []
        links = RobotLinks(self.layout(inner), hubs, keys=keys, operator="bob")
        for link in links.values():
            link.start()
            self._stack.callback(link.close)
        return links

    def agent(self, role: Role | None) -> Client:
        """What sends a pad, with a key of this role or, on the hub's machine, with none."""
        keys = read_client_keys(self._keyring.make(role.value, role)) if role else None
        name = role.value if role else "local"
        client = Client(name, self.central.endpoints[1 if keys else 0], keys=keys)
        self._stack.enter_context(closing(client))
        client.define(*MESSAGES)
        client.wait_connected(10.0)
        return client


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[Hub]:
    with ExitStack() as stack:
        yield Hub(tmp_path, stack)


def sends(client: Client) -> None:
    """The pad is there, and at rest."""
    client.publish(PAD_DEVICE, told_device(machine=client.name))
    values = np.zeros(len(CONTROLS), np.int32)
    client.publish(PAD_STATE, PadState(session=1, values=values))
    client.listen(0.02)


def devices(links: RobotLinks) -> list[str]:
    """What has been plugged in since the last call."""
    news = [each for each in links.pads.news() if isinstance(each, Scanned)]
    return [device.shown for each in news for device in each.devices]


@pytest.mark.parametrize("role", [None, Role.OPERATE])
def test_a_pad_of_who_may_operate_comes_to_a_console_whose_layout_has_joysticks(
    hub: Hub, role: Role | None
) -> None:
    links = hub.console()
    agent = hub.agent(role)
    shown = [f"F310 at {agent.name}"]
    until(lambda: devices(links) == shown, 10.0, meanwhile=lambda: sends(agent))
    kept = list(links.values())
    assert links.follow(hub.layout("")) == []
    until(lambda: not agent.has_subscribers(PAD_STATE), 10.0, meanwhile=lambda: agent.listen(0.02))
    assert links.follow(hub.layout(JOYSTICK)) == []
    until(lambda: agent.has_subscribers(PAD_STATE), 10.0, meanwhile=lambda: agent.listen(0.02))
    assert list(links.values()) == kept


def test_a_console_tells_who_sits_there_and_whose_pads_it_uses(hub: Hub) -> None:
    links = hub.console()
    agent = hub.agent(Role.OPERATE)
    told: list[PadConsole] = []
    agent.subscribe(PAD_CONSOLE, lambda console, _: told.append(console))

    def says(*numbers: int) -> bool:
        return bool(told) and (told[-1].operator, told[-1].taken.tolist()) == ("bob", [*numbers])

    until(says, 10.0, meanwhile=lambda: agent.listen(0.02))
    devices: list[DeviceInfo] = []

    def scan() -> None:
        sends(agent)
        scanned = [each for each in links.pads.news() if isinstance(each, Scanned)]
        devices.extend(device for each in scanned for device in each.devices)

    until(lambda: devices, 10.0, meanwhile=scan)
    links.pads.read(devices[0])
    until(lambda: says(agent.number), 10.0, meanwhile=lambda: sends(agent))
    links.pads.stop(devices[0].path)
    until(says, 10.0, meanwhile=lambda: sends(agent))
    links.follow(hub.layout(""))
    until(lambda: not agent.has_subscribers(PAD_STATE), 10.0, meanwhile=lambda: sends(agent))
    told.clear()
    agent.listen(2.0 / CONSOLE_HZ)
    assert told == []


def test_a_console_that_may_only_watch_tells_nothing_and_goes_on(hub: Hub) -> None:
    links = hub.console(role=Role.OBSERVE)
    agent = hub.agent(None)
    told: list[PadConsole] = []
    agent.subscribe(PAD_CONSOLE, lambda console, _: told.append(console))
    until(lambda: devices(links), 10.0, meanwhile=lambda: sends(agent))
    agent.listen(2.0 / CONSOLE_HZ)
    assert told == []


def test_who_may_only_observe_cannot_send_a_pad(hub: Hub) -> None:
    watcher = hub.agent(Role.OBSERVE)
    with pytest.raises(NotAllowedError, match="may not send GCM_Pad_"):
        sends(watcher)
