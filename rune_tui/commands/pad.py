"""`rune pad`: sends this machine's gamepad to consoles on other machines, through a robot's hub."""

from __future__ import annotations

import contextlib
import platform
import secrets
import shutil
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import field
from pathlib import Path
from typing import TextIO

from hub.command_line import ending_signals
from hub.errors import CentralUnreachableError, HubError
from hub.gcm import pad
from hub.ipc.client import Client
from hub.ipc.endpoints import shown
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.publish_rights import demand_right
from hub.values import dataclass
from rune_tui.controls.devices import local_devices
from rune_tui.controls.devices.device_reader import Gone, News, Opened, Refused, Scanned
from rune_tui.controls.devices.matching import DeviceInfo, assigned
from rune_tui.controls.devices.udev_rules import rule_advice
from rune_tui.controls.joystick_set import MOST_FAULTS
from rune_tui.controls.joystick_sources import Devices
from rune_tui.controls.remote_pad.pad_audience import Audience
from rune_tui.controls.remote_pad.pad_sender import PadSender
from rune_tui.errors import DeviceChoiceError
from rune_tui.layout.spec import JoystickSpec
from rune_tui.link.hub_tunnel import Tunnel, tunnel_to

CONNECT_S = 5.0
"""Longest wait for the hub at the start [s]; later losses have no limit."""
_TURN_S = 1.0 / pad.STATE_HZ
_SHOW_S = 0.5
_LAST_REPORT_S = 0.5
_ANY = "pad"
_START_OF_LINE, _REST_OF_LINE = "\r", "\x1b[K"


class Choice:
    """The choice of the joystick to send: by name or number, or the first.

    Attributes:
        shown: Its name while it is absent.
    """

    def __init__(self, wanted: str, devices: Sequence[DeviceInfo]) -> None:
        """Choose.

        Args:
            wanted: A number from 1, a name, a part of it, or a pattern of it; empty: any.
            devices: All present joysticks, in the order of their numbers.

        Raises:
            DeviceChoiceError: No joystick has this number.
        """
        self.shown = "a joystick to be plugged in"
        self._spec = JoystickSpec(name=_ANY)
        self._last: dict[str, DeviceInfo] = {}
        if wanted.isdecimal():
            if not 1 <= int(wanted) <= len(devices):
                text = f"there is no joystick {wanted}; `rune joytest --list` shows what there is"
                raise DeviceChoiceError(text)
            device = self._last[_ANY] = devices[int(wanted) - 1]
            self.shown = device.shown
            self._spec = JoystickSpec(
                name=_ANY, vid=device.vid, pid=device.pid, serial=device.serial
            )
        elif wanted:
            pattern = wanted if any(sign in wanted for sign in "*?[") else f"*{wanted}*"
            self._spec = JoystickSpec(name=_ANY, device=pattern)
            self.shown = f"a joystick called {wanted}"

    def of(self, devices: Sequence[DeviceInfo]) -> DeviceInfo | None:
        """The chosen device; the device before, if it is present again."""
        usable = [device for device in devices if device.joystick]
        found = assigned([self._spec], usable, self._last).get(_ANY)
        if found is not None:
            self._last[_ANY] = found
        return found


class Agent:
    """Reads the device and passes its reports to a sender; for one thread.

    Attributes:
        choice: The choice of the device.
        device: The device; None while absent.
        why: Why it cannot be read; else empty.
    """

    def __init__(self, choice: Choice, reader: Devices, sender: PadSender) -> None:
        self.device: DeviceInfo | None = None
        self.why = ""
        self.choice = choice
        self._reader, self._sender = reader, sender
        self._faults: dict[str, int] = {}

    def turn(self) -> None:
        """Take new reports, and send the states that are due."""
        for news in self._reader.news():
            self._learn(news)
        # Reports wait until the device is known to be open.
        opened = self.device is not None and self._sender.plugged
        inbox = self._reader.inbox(self.device.path) if self.device and opened else None
        self._sender.turn(inbox.take() if inbox else (), time.monotonic())

    def _learn(self, news: News) -> None:
        path = self.device.path if self.device else ""
        match news:
            case Scanned(devices=devices):
                here = {device.path for device in devices}
                self._faults = {p: count for p, count in self._faults.items() if p in here}
                self._follow(self.choice.of(devices))
            case Opened() if news.path == path and self.device is not None:
                self.why = ""
                self._sender.plug(self.device, news.controls, news.descriptor)
            case Refused() if news.path == path and self.device is not None:
                self.why = news.why
                if news.forbidden:
                    self.why += f"; {rule_advice(self.device)}"
                self._reader.stop(path)
            case Gone() if news.path == path:
                self._faults[path] = self._faults.get(path, 0) + 1
                self._follow(None)

    def _follow(self, device: DeviceInfo | None) -> None:
        if device == self.device:
            return
        if self.device is not None:
            self._reader.stop(self.device.path)
            self._sender.unplug()
        self.device, self.why = device, ""
        if device is None:
            return
        if self._faults.get(device.path, 0) > MOST_FAULTS:
            self.why = "it falls silent again and again; plug it in again"
        else:
            self._reader.read(device)


@dataclass(slots=True, kw_only=True)
class Progress:
    """One status line: rewritten on a terminal, else written at each change.

    Attributes:
        agent: Reads the device.
        sender: Sends its states.
        audience: The consoles that may use it.
        client: The connection to the hub.
        tunnel: The ssh tunnel, if any.
        out: The stream to write to.
    """

    agent: Agent
    sender: PadSender
    audience: Audience
    client: Client
    tunnel: Tunnel | None
    out: TextIO = field(default_factory=lambda: sys.stderr)
    _written: str = ""
    _looked: float = field(default_factory=time.monotonic)
    _sent: int = 0

    def show(self) -> None:
        """Write the line."""
        flow = self._flow()
        if self.out.isatty():
            line = self._line(flow)[: shutil.get_terminal_size().columns - 1]
            self.out.write(f"{_START_OF_LINE}{line}{_REST_OF_LINE}")
        elif (line := self._line("")) != self._written:
            self.out.write(f"{line}\n")
        self._written = line
        self.out.flush()

    def end(self) -> None:
        """End the line."""
        if self.out.isatty() and self._written:
            self.out.write("\n")

    def _line(self, flow: str) -> str:
        """The whole line; `flow` is empty if lines cannot be rewritten."""
        agent, client = self.agent, self.client
        device = agent.device.shown if agent.device else f"waiting for {agent.choice.shown}"
        device += f": {agent.why}" if agent.why else ""
        where = f"ssh {self.tunnel.destination}" if self.tunnel else shown(client.endpoint)
        if not client.connected:
            tunnel = self.tunnel.trouble if self.tunnel else ""
            why = tunnel or str(client.refusal or "the hub does not answer; trying again")
            return f"{device}; {where}: {why}"
        used = ""
        if self.sender.plugged:
            used = f"; {self.audience.words(client.number, time.monotonic())}"
        return f"{device}{used}{flow}; connected to {where}"

    def _flow(self) -> str:
        """The part that changes all the time: rate and round trip."""
        now, sent = time.monotonic(), self.sender.sent
        rate = (sent - self._sent) / max(now - self._looked, 1e-3)
        self._looked, self._sent = now, sent
        flow = f"; {self.client.round_trip * 1e3:.0f} ms there and back"
        if not self.sender.plugged:
            return flow
        return f"; {rate:.0f} states/s, {'moved' if self.sender.active else 'at rest'}{flow}"


def run(
    hub: str,
    *,
    ssh: str = "",
    keys: Path | None = None,
    device: str = "",
    operator: str = "",
) -> None:
    """Send a joystick's states until Ctrl-C; continue after losses of device and hub.

    Args:
        hub: Endpoint of the robot's hub; with `ssh`, as seen from the robot.
        ssh: Destination [USER@]HOST[:PORT]; empty: no ssh.
        keys: File of the operator's key, for a hub on another machine.
        device: The joystick; see `Choice`.
        operator: Operator of the receiving console; empty: any at this hub.

    Raises:
        DeviceChoiceError: There is no such joystick.
        HidMissingError: There is no hidapi.
        TunnelError: Ssh cannot open a tunnel.
        CentralUnreachableError: No hub answers.
        HubError: The hub refuses the connection, or this key may not send states.
    """
    choice = Choice(device, local_devices.joysticks_here())
    own_keys = read_client_keys(keys) if keys else None
    if own_keys is not None:
        plane = pad.PAD_STATE.plane.value
        demand_right(own_keys.principal, "rune pad", pad.PAD_STATE.name, plane)
    with contextlib.ExitStack() as stack:
        tunnel = stack.enter_context(contextlib.closing(tunnel_to(ssh, hub))) if ssh else None
        if tunnel is not None:
            tunnel.open()
        # A process number is not unique across machines.
        name = f"rune-pad-{secrets.token_hex(4)}"
        endpoint = tunnel.endpoint if tunnel else hub
        client = Client(name, endpoint, keys=own_keys, near=tunnel is None)
        stack.callback(client.close)
        client.define(*pad.MESSAGES)
        if sys.stderr.isatty():
            sys.stderr.write(
                f"connecting to {f'ssh {ssh}' if ssh else shown(hub)}; Ctrl-C ends it\n"
            )
        _wait_connected(client, "" if tunnel is None else f"ssh {tunnel.destination}")
        client.wait_defined(CONNECT_S)
        sender = PadSender(
            lambda announced: client.publish(pad.PAD_DEVICE, announced),
            lambda state: client.publish(pad.PAD_STATE, state),
            operator=operator,
            machine=platform.node(),
        )
        reader = local_devices.reader()
        agent = Agent(choice, reader, sender)
        audience = Audience(operator)
        client.subscribe(
            pad.PAD_CONSOLE,
            lambda announced, by: audience.hear(by.publisher, announced, time.monotonic()),
        )
        progress = Progress(
            agent=agent, sender=sender, audience=audience, client=client, tunnel=tunnel
        )
        stack.callback(progress.end)
        stack.callback(reader.close)
        stack.callback(_report_unplugged, client, sender)
        ended = stack.enter_context(_ends())
        reader.start(lambda: client.post(agent.turn))
        client.every(_TURN_S, agent.turn)
        client.every(_SHOW_S, progress.show)
        while not ended.is_set():
            client.listen(_TURN_S)


def _wait_connected(client: Client, beyond: str) -> None:
    """Wait until the hub answers; the error names another way to connect.

    Args:
        client: The connection.
        beyond: The hub's endpoint and destination, if through ssh.

    Raises:
        HubError: The hub does not answer, or refuses.
    """
    try:
        client.wait_connected(CONNECT_S)
    except CentralUnreachableError as error:
        text = (
            f"{str(error).removesuffix('?')}; to reach the robot through ssh, add --ssh USER@HOST"
        )
        if beyond:
            text = f"no hub answers at {beyond}; is rune-hub running there?"
        raise CentralUnreachableError(text) from error


def _report_unplugged(client: Client, sender: PadSender) -> None:
    """Report the device as unplugged, if the hub answers."""
    sender.end()
    with contextlib.suppress(HubError):
        client.wait_published(_LAST_REPORT_S)


@contextlib.contextmanager
def _ends() -> Iterator[threading.Event]:
    """An event that is set by Ctrl-C and by the system's signal to end."""
    ended = threading.Event()
    numbers = ending_signals()
    before = [signal.signal(number, lambda *_: ended.set()) for number in numbers]
    try:
        yield ended
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
