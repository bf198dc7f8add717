"""When the state of a gamepad is sent to consoles of other machines, and its content; pure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable

import numpy as np

from hub.gcm import pad
from hub.gcm.pad import PadDevice, PadState
from hub.own_pauses import OwnPauses
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.hid.reading import Value
from rune_tui.controls.joystick.logical import LogicalJoystick
from rune_tui.controls.remote_pad.pad_values import Row
from rune_tui.layout.spec import ControlKind, ControlSpec, JoystickSpec

ACTIVE_FOR_S = 1.0
"""A pad is in use until this time after its last change [s]."""
DEAD_ZONE = 0.02
"""Smaller than usual in layouts: a control that drives there counts as in use here."""
_WAITS = 1
_EARLY_S = 0.002
"""A timer may be that much ahead of its time [s]."""


class PadSender:
    """Sends one device at a time: its announcement and its states.

    Attributes:
        session: Number of its sessions; each device begins one.
        sent: Number of states sent.
        active: Whether the device is in use.
    """

    def __init__(
        self,
        send_device: Callable[[PadDevice], None],
        send_state: Callable[[PadState], None],
        *,
        operator: str = "",
        machine: str = "",
    ) -> None:
        """Start without a device.

        Args:
            send_device: Sends the announcement of the device.
            send_state: Sends the state of its controls.
            operator: The operator whose console may use it; empty: any.
            machine: Name of this machine, for people.
        """
        self.session = self.sent = 0
        self.active = False
        self._send_device, self._send_state = send_device, send_state
        self._operator, self._machine = operator, machine
        self._pauses = OwnPauses(pad.OLDEST_S)
        self._described: PadDevice | None = None
        self._row = Row(())
        self._joystick = LogicalJoystick(JoystickSpec(name="pad"))
        self._device_sent = self._state_sent = self._changed = -math.inf

    @property
    def plugged(self) -> bool:
        """Whether there is a device to send."""
        return self._described is not None

    def plug(
        self, info: DeviceInfo, controls: tuple[PhysicalControl, ...], descriptor: bytes
    ) -> None:
        """A device can be read."""
        self._described = PadDevice(
            session=0,
            operator=self._operator,
            machine=self._machine,
            name=info.name,
            vid=info.vid,
            pid=info.pid,
            serial=info.serial,
            port=info.port,
            bus=info.bus,
            descriptor=np.frombuffer(descriptor, np.uint8),
        )
        self._row = Row(controls)
        specs = tuple(
            ControlSpec(name=each.usage, kind=each.kind, usage=each.usage, deadzone=DEAD_ZONE)
            for each in controls
            if each.kind is not ControlKind.BALL  # which is never held
        )
        self._joystick = LogicalJoystick(JoystickSpec(name="pad", controls=specs))
        self._joystick.connect(controls, {})
        self._begin()

    def unplug(self) -> None:
        """Release the device there now, because it is gone."""
        if self._described is not None:
            self._send_state(PadState(session=self.session, active=_WAITS))
        self._described, self.active = None, False
        self._state_sent = -math.inf

    def end(self) -> None:
        """Stop: report the device as gone, so that consoles release its input at once."""
        self._send_state(PadState(session=self.session))
        self._described, self.active = None, False

    def turn(self, values: Iterable[Value], now: float) -> None:
        """Send the messages that are due; call it at least every 20 ms.

        Args:
            values: The device's reports since the last call.
            now: The time now [s].
        """
        values = tuple(values)
        changed = self._row.take(values)
        self._joystick.feed(values, now)
        paused = self._pauses.look(now)
        if self._described is None:
            self._report_absence(now)
            return
        if paused:
            # Input during a pause of this process is not known: the device must be neutral first.
            self._begin()
        self._changed = now if changed else self._changed
        self.active = now - self._changed < ACTIVE_FOR_S or any(self._joystick.values.values())
        if now - self._device_sent > 1.0 / pad.DEVICE_HZ - _EARLY_S:
            self._announce(now)
        rate = pad.STATE_HZ if self.active else pad.ALIVE_HZ
        if now - self._state_sent > 1.0 / rate - _EARLY_S:
            self._report_state(now)

    def _begin(self) -> None:
        self.session += 1
        self._device_sent = self._state_sent = -math.inf

    def _announce(self, now: float) -> None:
        about = self._described
        if about is not None:
            self._send_device(dataclasses.replace(about, session=self.session))
            self._device_sent = now

    def _report_absence(self, now: float) -> None:
        """Repeat that the device is gone: a console that missed it would see a silence."""
        if self.session and now - self._state_sent > 1.0 / pad.DEVICE_HZ - _EARLY_S:
            self._send_state(PadState(session=self.session, active=_WAITS))
            self._state_sent = now

    def _report_state(self, now: float) -> None:
        row = np.array(self._row.values, np.int32)
        state = PadState(session=self.session, active=int(self.active), values=row)
        self._send_state(state)
        self.sent += 1
        self._state_sent = now
