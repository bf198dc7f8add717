"""What gamepads at other machines say at one robot's hub."""

from __future__ import annotations

from hub.gcm.pad import PAD_DEVICE, PAD_STATE, PadDevice, PadState
from hub.ipc.client import Client
from hub.ipc.reception import Reception
from rune_tui.controls.far_pads import FarPads


class PadLine:
    """Used by the link's thread alone."""

    def __init__(self, client: Client, robot: str) -> None:
        self._client = client
        self._robot = robot
        self._pads: FarPads | None = None

    def follow(self, pads: FarPads | None) -> None:
        """Put what comes in there from now on; None: let nothing come."""
        before, self._pads = self._pads, pads
        if pads is not None and before is None:
            self._client.subscribe(PAD_DEVICE, self._device)
            self._client.subscribe(PAD_STATE, self._state, priority=1)
        elif pads is None and before is not None:
            self._client.unsubscribe(PAD_DEVICE, self._device)
            self._client.unsubscribe(PAD_STATE, self._state)

    def _device(self, told: PadDevice, reception: Reception) -> None:
        if self._pads is not None:
            self._pads.device_came((self._robot, reception.publisher), told)

    def _state(self, state: PadState, reception: Reception) -> None:
        if self._pads is not None:
            self._pads.state_came((self._robot, reception.publisher), state, reception.measured)
