"""All joysticks of a layout: their devices, their events and their reports."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Protocol

from rune_tui.controls.devices.device_reader import Gone, News, Opened, Refused, Scanned
from rune_tui.controls.devices.hid_reader import HidMissingError
from rune_tui.controls.devices.inbox import Inbox
from rune_tui.controls.devices.matching import DeviceInfo, assigned
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.joystick.calibration import Calibration, Guide
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.controls.joystick.logical import LogicalJoystick
from rune_tui.controls.joystick.mappings import Mappings
from rune_tui.controls.joystick_seat import JoystickSeat
from rune_tui.controls.joystick_sources import Devices
from rune_tui.layout.spec import ControlKind, JoystickSpec
from rune_tui.model.joystick_state import Absence, JoystickState

MOST_FAULTS = 3
"""Number of silences of a connected device after which it is given up."""
_FALLS_SILENT = "it falls silent again and again; unplug it, wait, plug it in"


class Reader(Devices, Protocol):
    """The reader of devices; see `Sources`."""

    def measured(self, path: str) -> float | None:
        """When the newest state of another machine's device was measured [s]; else None."""

    def absence(self, path: str) -> Absence | None:
        """Why another machine's device is gone; None: not known."""


class Joysticks:
    """The joysticks of a layout, plugged in or not; the clock is passed in.

    Attributes:
        store: The calibrations of devices.
        unsaved: Whether the store has something to write.
    """

    def __init__(
        self, specs: Sequence[JoystickSpec], reader: Reader, store: CalibrationStore
    ) -> None:
        """Prepare.

        Args:
            specs: The joysticks of the layout.
            reader: Reads devices; it is started when a layout has joysticks.
            store: The calibrations of devices.
        """
        self.store = store
        self.unsaved = False
        self._mappings = Mappings()
        self._reader = reader
        self._running, self._absence_reasons = False, ""
        self._devices: tuple[DeviceInfo, ...] = ()
        self._faults: dict[str, int] = {}
        self._unfit: dict[str, str] = {}
        self._said: list[str] = []
        self._waiting: deque[ControlEvent] = deque()
        self._notify: Callable[[], None] | None = None
        self._seats = [JoystickSeat(LogicalJoystick(spec)) for spec in specs]
        self._shown: Mapping[str, JoystickState] | None = None
        self._measured: tuple[float | None, ...] = ()

    def start(self, notify: Callable[[], None]) -> None:
        """Search for devices from now on, while the layout has joysticks.

        Args:
            notify: Called from other threads when there are events.
        """
        self._notify = notify
        self._start()

    def _start(self) -> None:
        if self._notify is None or not self._seats or self._running:
            return
        if self.store.trouble:
            self._said.append(self.store.trouble)
        self._running = True
        try:
            self._reader.start(self._notify)
        except HidMissingError as error:  # devices of other machines are read
            self._absence_reasons = str(error)
            self._mark_absent()

    def close(self) -> None:
        """Leave all devices alone."""
        if self._running:
            self._reader.close()
            self._running = False

    def follow(self, specs: Sequence[JoystickSpec], now: float) -> None:
        """Change to another layout's joysticks; devices that both use stay open."""
        before = {seat.name: seat for seat in self._seats}
        self._seats = []
        self._shown = None
        for spec in specs:
            seat = before.get(spec.name, JoystickSeat(LogicalJoystick(spec)))
            seat.joystick, seat.guide = LogicalJoystick(spec), None
            self._seats.append(seat)
        self._start()
        self._mark_absent()
        kept = {seat.name: seat for seat in self._seats if seat.still_fits}
        for name, seat in before.items():
            if name not in kept and seat.device is not None:
                self._reader.stop(seat.device.path)
                seat.vacate()
                seat.device = None
        for seat in kept.values():
            if seat.connected:
                self._seated(seat, seat.controls, now)
        self._waiting.clear()
        self._assign()

    def events(self, now: float) -> Iterator[ControlEvent]:
        """The new events of devices, without controls that were released meanwhile."""
        self._gather(now)
        while self._waiting:
            yield self._waiting.popleft()

    def release_all(self, now: float) -> tuple[ControlEvent, ...]:
        """Release everything, and drop pending events.

        Returns:
            That axes are neutral now, and which buttons went up. Buttons that are still held are
            released without an event, because their action at release is not intended.
        """
        self._gather(now)
        self._shown = None
        released = [event for event in self._waiting if not event.pressed]
        self._waiting.clear()
        for seat in self._seats:
            axes = seat.joystick.axis_inputs
            released += [each for each in seat.joystick.release_all() if each.name in axes]
        return tuple(released)

    def _gather(self, now: float) -> None:
        for news in self._reader.news() if self._running else ():
            self._waiting += self._learn(news, now)
        for seat in self._seats:
            inbox = self._inbox(seat)
            values = inbox.take() if inbox is not None else ()
            if values:
                self._shown = None
                self._waiting += self._fed(seat, values, now)

    def tick(self, now: float) -> list[str]:
        """Apply the time limits; returns reports for the operator."""
        for seat in self._seats:
            if seat.guide is not None:
                seat.guide.expire(now)
                self._conclude(seat, now)
        said, self._said = self._said, []
        return said

    def calibrate(self, name: str, control: str, now: float) -> None:
        """Begin the calibration of axes by the operator; if it is active, end it.

        Args:
            name: The joystick; empty: the first.
            control: One of its axes; empty: those that the layout names, or all.
            now: The time now [s].
        """
        seat = next((each for each in self._seats if name in {"", each.name}), None)
        if seat is None:
            self._said.append(f"the layout has no joystick {name}".rstrip())
        elif seat.guide is not None:
            seat.guide = self._shown = None
            self._said.append(f"{seat.name} is not calibrated: you ended it")
        elif not seat.connected:
            self._said.append(f"{seat.name} cannot be calibrated: it is not plugged in")
        elif not (axes := seat.joystick.to_calibrate(control)):
            self._said.append(f"{seat.name} has no axis {control}".rstrip())
        else:
            self._waiting += seat.joystick.release_all()
            seat.guide = Guide(axes, now)
            self._shown = None
            if self._notify is not None:
                self._notify()  # a motionless stick sends no reports

    @property
    def states(self) -> Mapping[str, JoystickState]:
        """The state of each, by name."""
        measured = tuple(
            self._reader.measured(far.path) if seat.connected and (far := seat.far) else None
            for seat in self._seats
        )
        if self._note_absences() or self._shown is None or measured != self._measured:
            self._measured = measured
            self._shown = MappingProxyType(
                {
                    seat.name: seat.state(when)
                    for seat, when in zip(self._seats, measured, strict=True)
                }
            )
        return self._shown

    def _note_absences(self) -> bool:
        """Note the absences of devices of other machines; whether any is new."""
        changed = False
        for seat in self._seats:
            if seat.connected or not (far := seat.far):
                continue
            # A pad without messages is forgotten there; its last report is kept here.
            absence = self._reader.absence(far.path) or seat.absence
            changed |= absence is not seat.absence
            seat.absence = absence
        return changed

    def _inbox(self, seat: JoystickSeat) -> Inbox | None:
        if not seat.connected or seat.device is None:
            return None
        return self._reader.inbox(seat.device.path)

    def _fed(
        self, seat: JoystickSeat, values: Sequence[tuple[int, int | None]], now: float
    ) -> tuple[ControlEvent, ...]:
        events = seat.joystick.feed(values, now)
        if seat.guide is None:
            return events
        seat.joystick.release_all()
        kinds = [control.kind for control in seat.controls]
        if any(raw and kinds[position] is ControlKind.BUTTON for position, raw in values):
            seat.guide.accept(seat.joystick.raws(), now)
            self._conclude(seat, now)
        return ()

    def _conclude(self, seat: JoystickSeat, now: float) -> None:
        """Use the calibration, if it is complete."""
        guide = seat.guide
        if guide is None or not guide.ended or seat.device is None:
            return
        seat.guide = self._shown = None
        if guide.given_up:
            self._said.append(f"{seat.name} is not calibrated: nothing was done for too long")
            return
        self.store.add(seat.device.key, guide.found)
        self.unsaved = True
        self._seated(seat, seat.controls, now)
        self._said.append(f"{seat.name} is calibrated")

    def _learn(self, news: News, now: float) -> tuple[ControlEvent, ...]:
        self._shown = None
        match news:
            case Scanned(devices=devices):
                self._devices = devices
                return self._assign()
            case Opened(path=path, controls=controls):
                for seat in self._at(path):
                    self._seated(seat, self._mapped(seat, controls), now)
                    seat.ask_for_ends(self._known(seat), now)
            case Refused():
                self._refused(news)
            case Gone(path=path):
                self._reader.stop(path)
                self._faults[path] = self._faults.get(path, 0) + 1
                return tuple(event for seat in self._at(path) for event in seat.vacate())
        return ()

    def _at(self, path: str) -> list[JoystickSeat]:
        return [seat for seat in self._seats if seat.device and seat.device.path == path]

    def _mapped(
        self, seat: JoystickSeat, controls: tuple[PhysicalControl, ...]
    ) -> tuple[PhysicalControl, ...]:
        """With the roles that the user's own file gives them."""
        if seat.device is not None:
            controls = self._mappings.applied(seat.device, controls)
        if self._mappings.fault:
            self._said.append(self._mappings.fault)
        return controls

    def _seated(
        self, seat: JoystickSeat, controls: tuple[PhysicalControl, ...], now: float
    ) -> None:
        """Take an open device; a control that is deflected now must be neutral first."""
        seat.connect(controls, self._known(seat))
        inbox = self._inbox(seat)
        seat.joystick.feed(inbox.everything() if inbox else (), now)
        seat.joystick.release_all()

    def _known(self, seat: JoystickSeat) -> Mapping[str, Calibration]:
        """The known ranges of its device's axes, by usage."""
        return self.store.of(seat.device.key) if seat.device else {}

    def _refused(self, news: Refused) -> None:
        self._reader.stop(news.path)
        if news.unsuitable:
            self._unfit[news.path] = news.why
        for seat in self._at(news.path):
            seat.refuse(news)

    def _assign(self) -> tuple[ControlEvent, ...]:
        """Assign devices to joysticks."""
        events: list[ControlEvent] = []
        here = {device.path for device in self._devices}
        self._faults = {path: count for path, count in self._faults.items() if path in here}
        self._unfit = {path: why for path, why in self._unfit.items() if path in here}
        last = {seat.name: seat.device for seat in self._seats if seat.device is not None}
        specs = [seat.joystick.spec for seat in self._seats]
        usable = [device for device in self._devices if device.joystick]
        found = assigned(specs, usable, last)
        for seat in self._seats:
            device = found.get(seat.name)
            if seat.device is not None and device != seat.device:
                self._reader.stop(seat.device.path)
                events += seat.vacate()
            if device is None:
                seat.explain(self._devices, self._absence_reasons)
                continue
            if device != seat.device:
                seat.absence = Absence.SILENT if device.machine else Absence.UNPLUGGED
            seat.device = device
            if not seat.connected:
                self._open(seat, device)
        return tuple(events)

    def _open(self, seat: JoystickSeat, device: DeviceInfo) -> None:
        if self._faults.get(device.path, 0) > MOST_FAULTS:
            self._unfit[device.path] = _FALLS_SILENT
        if device.path in self._unfit:
            seat.mark_unsuitable(self._unfit[device.path])
        else:
            self._reader.read(device)

    def _mark_absent(self) -> None:
        for seat in self._seats if self._absence_reasons else ():
            if not seat.connected:
                seat.mark_unsuitable(self._absence_reasons)
        self._shown = None
