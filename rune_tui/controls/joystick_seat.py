"""A joystick of the layout, its device, and the state of both.

| event | phase afterwards |
| --- | --- |
| its device can be read | CONNECTED |
| its device may not be read | FORBIDDEN |
| its device is no joystick, or cannot be understood | UNSUITABLE |
| its device is gone | MISSING |
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from hub.values import dataclass
from rune_tui.controls.devices.device_reader import Refused
from rune_tui.controls.devices.matching import DeviceInfo, is_meant, is_particular
from rune_tui.controls.devices.udev_rules import rule_advice
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.joystick.calibration import Calibration, Guide
from rune_tui.controls.joystick.logical import LogicalJoystick
from rune_tui.model.joystick_state import Absence, JoystickPhase, JoystickState


@dataclass(slots=True)
class JoystickSeat:
    """A joystick of the layout and its device.

    Attributes:
        joystick: Turns its device's values into events.
        device: The device; the last one while it is gone.
        controls: The device's controls.
        phase: Whether it can be used.
        why: The reason for its absence, or its lacks, in words.
        guide: The calibration under way; None: there is none.
        absence: The reason for the absence of another machine's device.
    """

    joystick: LogicalJoystick
    device: DeviceInfo | None = None
    controls: tuple[PhysicalControl, ...] = ()
    phase: JoystickPhase = JoystickPhase.MISSING
    why: str = ""
    guide: Guide | None = None
    absence: Absence = Absence.UNPLUGGED

    @property
    def name(self) -> str:
        """Its name in the layout."""
        return self.joystick.spec.name

    @property
    def connected(self) -> bool:
        """Whether its device is read."""
        return self.phase is JoystickPhase.CONNECTED

    @property
    def far(self) -> DeviceInfo | None:
        """Its device, if that is at another machine; else None."""
        return self.device if self.device is not None and self.device.machine else None

    @property
    def still_fits(self) -> bool:
        """Whether the layout means its device."""
        return self.device is not None and is_meant(self.joystick.spec, self.device)

    def state(self, measured: float | None) -> JoystickState:
        """Its state; `measured`: time of its newest values [s], None: now."""
        device = self.device
        return JoystickState(
            name=self.name,
            device=device.shown if device else "",
            phase=self.phase,
            why=self.why,
            values=dict(self.joystick.values),
            waiting=frozenset() if self.guide else self.joystick.waiting,
            prompt=self.guide.prompt if self.guide else "",
            machine=device.machine if device else "",
            measured=measured,
            absence=self.absence,
        )

    def connect(
        self, controls: tuple[PhysicalControl, ...], known: Mapping[str, Calibration]
    ) -> None:
        """Its device can be read; it has these controls and known calibrations."""
        missing = self.joystick.connect(controls, known)
        self.controls = controls
        self.phase = JoystickPhase.CONNECTED
        self.why = f"it has no {', '.join(missing)}" if missing else ""

    def ask_for_ends(self, known: Mapping[str, Calibration], now: float) -> None:
        """Begin the calibration of the axes that the layout names, if they have none."""
        marked = {spec.name for spec in self.joystick.spec.controls if spec.calibrate}
        axes = [axis for axis in self.joystick.to_calibrate() if axis.control in marked]
        unknown = [axis for axis in axes if axis.usage not in known]
        if unknown:
            self.guide = Guide(unknown, now)

    def refuse(self, news: Refused) -> None:
        """Its device cannot be read."""
        if news.forbidden and self.device is not None:
            self.phase = JoystickPhase.FORBIDDEN
            self.why = f"no permission to read it; {rule_advice(self.device)}"
        elif news.unsuitable:
            self.mark_unsuitable(news.why)

    def mark_unsuitable(self, why: str) -> None:
        """It cannot be used."""
        self.phase, self.why = JoystickPhase.UNSUITABLE, why

    def vacate(self) -> tuple[ControlEvent, ...]:
        """Drop a device that is gone; its identity is kept."""
        was_connected = self.connected
        self.phase, self.why, self.guide = JoystickPhase.MISSING, "", None
        return self.joystick.lost() if was_connected else ()

    def explain(self, devices: Iterable[DeviceInfo], mark_absent: str) -> None:
        """Set the reason why no connected device fits or can be read."""
        spec = self.joystick.spec
        meant = next((each for each in devices if is_meant(spec, each)), None)
        if meant is not None and not meant.joystick and is_particular(spec):
            self.mark_unsuitable(f"{meant.shown} is no joystick")
        elif mark_absent and not (self.device and self.device.machine):
            self.mark_unsuitable(mark_absent)
        else:
            self.phase, self.why = JoystickPhase.MISSING, ""
