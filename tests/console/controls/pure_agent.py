"""A machine with a gamepad and `rune pad`, and a console's way to hear of it, without a process."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hub.gcm.pad import PadDevice, PadState
from rune_tui.controls.hid.reading import Value
from rune_tui.controls.remote_pad.far_pads import FarPads
from rune_tui.controls.remote_pad.pad_sender import PadSender
from tests.console.controls.hid.fixtures import device as recorded
from tests.console.controls.joystick.pads import device
from tests.console.controls.slow_link import Link

_F310 = recorded("logitech_f310_dinput")
_CONTROLS = _F310.decoder().controls


class HeardPads(FarPads):
    """As the console has them, but for the thread that waits: here it is asked all the time."""

    def start(self, notify: Callable[[], None]) -> None:
        """Time passes where it is asked."""


class PadAgent:
    """`rune pad` with a pad that is plugged in.

    Attributes:
        runs: Whether it does; False while it is stopped, or dead.
        link: Its way to the console.
    """

    def __init__(self, link: Link, now: float) -> None:
        self.runs = True
        self.link = link
        self._now = now
        self._reported: list[Value] = []
        self._sender = PadSender(self._send, self._send)
        self._sender.plug(device(), _CONTROLS, _F310.descriptor)

    def _send(self, message: PadDevice | PadState) -> None:
        self.link.send(message, self._now)

    def report(self, values: Iterable[Value]) -> None:
        """What the pad says; whoever does not run reads it later."""
        self._reported += values

    def pass_time(self, now: float) -> None:
        """As `rune pad` does, every 20 ms."""
        if self.runs:
            self._now = now
            self._sender.turn(self._reported, now)
            self._reported.clear()

    def told(self, pads: FarPads, now: float) -> None:
        """The console hears what has come on the way."""
        sender = ("magellan", self.link.number)
        for sent, message in self.link.arrived(now):
            if isinstance(message, PadDevice):
                pads.device_came(sender, message)
            else:
                pads.state_came(sender, message, sent)
