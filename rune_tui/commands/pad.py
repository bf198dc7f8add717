"""`rune pad`: sends the gamepad of this machine to consoles elsewhere, through a robot's hub."""

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
from dataclasses import dataclass, field
from pathlib import Path
from typing import TextIO

from hub.errors import CentralUnreachableError, HubError
from hub.gcm import pad
from hub.ipc.client import Client
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.publish_rights import demand_right
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
from rune_tui.link.tunnel import Tunnel

CONNECT_S = 5.0
"""Time for the hub to answer at the start [s]; later it may be away for as long as it wants."""
_TURN_S = 1.0 / pad.STATE_HZ
_SHOW_S = 0.5
_LAST_WORD_S = 0.5
_ANY = "pad"
_START_OF_LINE, _REST_OF_LINE = "\r", "\x1b[K"


class Choice:
    """Which of the joysticks of this machine is sent: one that was named, or the first.

    Attributes:
        shown: What to call it while it is not there.
    """

    def __init__(self, wanted: str, devices: Sequence[DeviceInfo]) -> None:
        """Choose.

        Args:
            wanted: A number, from 1, a name or a part of it, or a pattern of one; empty: any.
            devices: All joysticks that are plugged in now, in the order of their numbers.

        Raises:
            DeviceChoiceError: There is none of this number.
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
        """The one of these; the one before, if it is there again."""
        usable = [device for device in devices if device.joystick]
        found = assigned([self._spec], usable, self._last).get(_ANY)
        if found is not None:
            self._last[_ANY] = found
        return found


class Agent:
    """Reads the device and hands what it reports to a sender; used by one thread.

    Attributes:
        choice: Which it is.
        device: The device that is sent; None while there is none.
        why: Why it cannot be read; empty if it can.
    """

    def __init__(self, choice: Choice, reader: Devices, sender: PadSender) -> None:
        self.device: DeviceInfo | None = None
        self.why = ""
        self.choice = choice
        self._reader, self._sender = reader, sender
        self._faults: dict[str, int] = {}

    def turn(self) -> None:
        """Take what has come, and send what is due."""
        for news in self._reader.news():
            self._learn(news)
        # What comes before the device is known to be open waits until it is.
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
            self.why = "it falls silent again and again; plug it in anew"
        else:
            self._reader.read(device)


@dataclass(slots=True, kw_only=True)
class Progress:
    """One line that says how it goes: on a terminal rewritten, else written when it changes.

    Attributes:
        agent: Has the device.
        sender: Sends it.
        audience: The consoles that may use it.
        client: The connection.
        tunnel: The way there, if there is one.
        out: Where the line is written.
    """

    agent: Agent
    sender: PadSender
    audience: Audience
    client: Client
    tunnel: Tunnel | None
    out: TextIO = field(default_factory=lambda: sys.stderr)
    _said: str = ""
    _looked: float = field(default_factory=time.monotonic)
    _sent: int = 0

    def show(self) -> None:
        """Say it."""
        flow = self._flow()
        if self.out.isatty():
            line = self._line(flow)[: shutil.get_terminal_size().columns - 1]
            self.out.write(f"{_START_OF_LINE}{line}{_REST_OF_LINE}")
        elif (line := self._line("")) != self._said:
            self.out.write(f"{line}\n")
        self._said = line
        self.out.flush()

    def end(self) -> None:
        """Leave the line."""
        if self.out.isatty() and self._said:
            self.out.write("\n")

    def _line(self, flow: str) -> str:
        """All of it; what says how it flows is left out where lines cannot be rewritten."""
        agent, client = self.agent, self.client
        device = agent.device.shown if agent.device else f"waiting for {agent.choice.shown}"
        device += f": {agent.why}" if agent.why else ""
        where = f"ssh {self.tunnel.destination}" if self.tunnel else client.endpoint
        if not client.connected:
            tunnel = self.tunnel.trouble if self.tunnel else ""
            why = tunnel or str(client.refusal or "the hub does not answer; trying again")
            return f"{device}; {where}: {why}"
        used = ""
        if self.sender.plugged:
            used = f"; {self.audience.words(client.number, time.monotonic())}"
        return f"{device}{used}{flow}; connected to {where}"

    def _flow(self) -> str:
        """What changes all the time."""
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
    """Send a joystick's states until the end of the command, through losses of device and hub.

    Args:
        hub: Endpoint of the robot's hub; with `ssh` as the robot itself knows it.
        ssh: Where ssh goes, [USER@]HOST[:PORT]; empty: not through ssh.
        keys: File of the operator's key, for a hub on another machine.
        device: Which joystick; see `Choice`.
        operator: Whose console it is for; empty: any at this hub.

    Raises:
        DeviceChoiceError: There is no such joystick.
        HidMissingError: There is no hidapi.
        TunnelError: There is no way through ssh.
        CentralUnreachableError: No hub answers.
        HubError: The hub cannot be asked, or does not let this key send states.
    """
    choice = Choice(device, local_devices.joysticks_here())
    own_keys = read_client_keys(keys) if keys else None
    if own_keys is not None:
        plane = pad.PAD_STATE.plane.value
        demand_right(own_keys.principal, "rune pad", pad.PAD_STATE.name, plane)
    with contextlib.ExitStack() as stack:
        tunnel = stack.enter_context(contextlib.closing(Tunnel(ssh, hub))) if ssh else None
        if tunnel is not None:
            tunnel.open()
        # A process has the number of one on another machine now and then.
        name = f"rune-pad-{secrets.token_hex(4)}"
        endpoint = tunnel.endpoint if tunnel else hub
        client = Client(name, endpoint, keys=own_keys, near=tunnel is None)
        stack.callback(client.close)
        client.define(*pad.MESSAGES)
        if sys.stderr.isatty():
            sys.stderr.write(f"connecting to {f'ssh {ssh}' if ssh else hub}; Ctrl-C ends it\n")
        _wait_connected(client, "" if tunnel is None else f"{hub} of ssh {tunnel.destination}")
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
        stack.callback(_say_the_last_word, client, sender)
        ended = stack.enter_context(_ends())
        reader.start(lambda: client.post(agent.turn))
        client.every(_TURN_S, agent.turn)
        client.every(_SHOW_S, progress.show)
        while not ended.is_set():
            client.listen(_TURN_S)


def _wait_connected(client: Client, beyond: str) -> None:
    """Wait until the hub answers; without an answer, say what else may be tried.

    Args:
        client: The connection.
        beyond: Where the hub is, if it is reached through ssh.

    Raises:
        HubError: It does not answer, or refuses.
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


def _say_the_last_word(client: Client, sender: PadSender) -> None:
    """Report the device as gone, if the hub answers."""
    sender.end()
    with contextlib.suppress(HubError):
        client.wait_published(_LAST_WORD_S)


@contextlib.contextmanager
def _ends() -> Iterator[threading.Event]:
    """Set when the operator or the system wants the process to end; nothing is cut off by it."""
    ended = threading.Event()
    names = [name for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    numbers = [getattr(signal, name) for name in names]
    before = [signal.signal(number, lambda *_: ended.set()) for number in numbers]
    try:
        yield ended
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
