"""Messages of and to gamepads at other machines, through one robot's hub."""

from __future__ import annotations

import numpy as np

from hub.gcm.pad import (
    CONSOLE_HZ,
    PAD_CONSOLE,
    PAD_DEVICE,
    PAD_STATE,
    PadConsole,
    PadDevice,
    PadState,
)
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from rune_tui.controls.remote_pad.far_pads import FarPads


class PadLine:
    """Used by the link's thread alone."""

    def __init__(self, client: Client, robot: str, *, publishes: bool) -> None:
        """Start without a receiver.

        Args:
            client: The link's.
            robot: The robot's name.
            publishes: Whether to publish the operator and the used pads: not every key may.
        """
        self._client = client
        self._robot = robot
        self._pads: FarPads | None = None
        if publishes:
            client.every(1.0 / CONSOLE_HZ, self._announce)

    def follow(self, pads: FarPads | None) -> None:
        """Set the receiver of states; None: none."""
        before, self._pads = self._pads, pads
        if pads is not None and before is None:
            self._client.subscribe(PAD_DEVICE, self._device)
            self._client.subscribe(PAD_STATE, self._state, priority=1)
        elif pads is None and before is not None:
            self._client.unsubscribe(PAD_DEVICE, self._device)
            self._client.unsubscribe(PAD_STATE, self._state)

    def _announce(self) -> None:
        if self._pads is not None and self._client.connected:
            taken = np.array(self._pads.senders_read(self._robot), np.uint32)
            console = PadConsole(operator=self._pads.operator, taken=taken)
            self._client.publish(PAD_CONSOLE, console)

    def _device(self, announced: PadDevice, reception: MessageInfo) -> None:
        if self._pads is not None:
            self._pads.device_came((self._robot, reception.publisher), announced)

    def _state(self, state: PadState, reception: MessageInfo) -> None:
        if self._pads is not None:
            self._pads.state_came((self._robot, reception.publisher), state, reception.measured)
