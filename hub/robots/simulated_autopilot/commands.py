"""The answers of a simulated autopilot to COMMAND_LONG and COMMAND_INT.

| command | answer |
| --- | --- |
| 176 set mode | accepted, or failed; denied without the flag of custom modes |
| 400 arm or disarm | accepted, or failed with texts; unsupported for other values |
| 511 rate of a message | accepted; denied for an unknown one, or above 80 % of the loop's rate |
| 510, 512, 520 tell a rate, a message, the version | accepted; failed for an unknown one |
| 241 calibrate the gyroscope | accepted after 2.1 s |
| 246 restart | accepted; failed while it is armed |
| 1000 turn the camera of a Sub | accepted |
| 183 set an output of a Sub | accepted; failed for one that the lights use |
| another | unsupported |
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from hub.robots.mavlink.wire.definitions import BY_NUMBER
from hub.robots.simulated_autopilot.condition import INFO, WARNING, VehicleCondition
from hub.robots.simulated_autopilot.reports import REPORTS, default_rates
from hub.robots.simulated_autopilot.station_link import StationLink

ACCEPTED: Final = 0
DENIED: Final = 2
UNSUPPORTED: Final = 3
FAILED: Final = 4
CALIBRATE: Final = 241
RESTART: Final = 246
CALIBRATING_S: Final = 2.1
_FORCE: Final = 21196.0
_FASTEST: Final = 0.8
_LARGEST_ID: Final = 1 << 24
_LIGHTS: Final = 9
_LONGEST_US: Final = 2.0**31 - 1.0
Parameters = tuple[float, ...]


def _set_mode(vehicle: VehicleCondition, _link: StationLink, values: Parameters) -> int:
    if not int(values[0]) & 1:
        return DENIED
    return ACCEPTED if vehicle.ask_mode(int(values[1])) else FAILED


def _arm(vehicle: VehicleCondition, _link: StationLink, values: Parameters) -> int:
    if values[0] == 0.0:
        vehicle.disarm()
        return ACCEPTED
    if values[0] != 1.0:
        return UNSUPPORTED
    return ACCEPTED if vehicle.ask_arm(force=values[1] == _FORCE) else FAILED


def _named(vehicle: VehicleCondition, number: float) -> str | None:
    """The name of a message that it can send; None: it cannot."""
    known = BY_NUMBER.get(int(number)) if 0.0 <= number < _LARGEST_ID else None
    if known is None or known.name not in REPORTS:
        vehicle.say(WARNING, f"No ap_message for mavlink id ({int(number)})")
        return None
    return known.name


def _set_rate(vehicle: VehicleCondition, link: StationLink, values: Parameters) -> int:
    name = _named(vehicle, values[0])
    if name is None:
        return DENIED
    every = values[1] / 1e6
    if values[1] < 0.0:
        every = math.inf
    elif values[1] == 0.0:
        rate = default_rates(vehicle.kind.name).get(name, 0.0)
        every = 1.0 / rate if rate else math.inf
    if every < 0.999 / (vehicle.kind.loop_hz * _FASTEST):
        return DENIED
    link.set_rate(name, every)
    return ACCEPTED


def _report_rate(vehicle: VehicleCondition, link: StationLink, values: Parameters) -> int:
    name = _named(vehicle, values[0])
    if name is None:
        return FAILED
    every = link.rates.get(name, math.inf)
    interval = round(min(every * 1e6, _LONGEST_US)) if every < math.inf else 0
    link.send("MESSAGE_INTERVAL", message_id=int(values[0]), interval_us=interval)
    return ACCEPTED


def _report_message(vehicle: VehicleCondition, link: StationLink, values: Parameters) -> int:
    name = _named(vehicle, values[0])
    if name is None:
        return FAILED
    fields = REPORTS[name](vehicle)
    if fields is not None:
        link.send(name, **fields)
    if name == "AUTOPILOT_VERSION":
        vehicle.say(INFO, vehicle.kind.version)
    return ACCEPTED


def _report_version(vehicle: VehicleCondition, link: StationLink, _values: Parameters) -> int:
    return _report_message(vehicle, link, (148.0,))


def _turn_camera(vehicle: VehicleCondition, _link: StationLink, values: Parameters) -> int:
    if vehicle.kind.name != "sub":
        return UNSUPPORTED
    if math.isfinite(values[0]):
        vehicle.tilt = math.radians(max(-45.0, min(45.0, values[0])))
    return ACCEPTED


def _set_output(vehicle: VehicleCondition, _link: StationLink, values: Parameters) -> int:
    if vehicle.kind.name == "sub" and int(values[0]) == _LIGHTS:
        vehicle.say(WARNING, f"Channel {_LIGHTS} is already in use")
        return FAILED
    return ACCEPTED


_ANSWERS: Final[Mapping[int, Callable[[VehicleCondition, StationLink, Parameters], int]]] = {
    176: _set_mode,
    400: _arm,
    510: _report_rate,
    511: _set_rate,
    512: _report_message,
    520: _report_version,
    1000: _turn_camera,
    183: _set_output,
}


def answer(vehicle: VehicleCondition, link: StationLink, command: int, values: Parameters) -> int:
    """Carry out a command; returns its MAV_RESULT."""
    act = _ANSWERS.get(command)
    finite = values[:1] if command == 1000 else values[:2]
    if act is None:
        return UNSUPPORTED
    if not all(map(math.isfinite, finite)):
        return DENIED
    return act(vehicle, link, values)
