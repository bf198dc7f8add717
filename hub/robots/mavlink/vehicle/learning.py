"""What a vehicle is asked when it is heard, and whether it answered; pure."""

from __future__ import annotations

import math
from typing import Final

from hub.robots.mavlink.profiles.profile import OLDER_NAMES, STREAMS, VehicleProfile
from hub.robots.mavlink.vehicle.parameter_reads import ParameterReads
from hub.robots.mavlink.vehicle.requests import RequestKind, RequestQueue, VehicleRequest
from hub.robots.mavlink.wire.definitions import BY_NAME

_INTERVAL: Final = 511
"""MAV_CMD_SET_MESSAGE_INTERVAL."""
_REQUEST: Final = 512
"""MAV_CMD_REQUEST_MESSAGE."""
_ASKED_ONCE: Final = ("AUTOPILOT_VERSION", "GPS_GLOBAL_ORIGIN", "GPS_RAW_INT")
_LONGEST_S: Final = 4.0
"""Longest time for the answers; what has none then is left out [s]."""
_SILENT_S: Final = 1.5
"""Time without ATTITUDE after which telemetry is silent [s]."""
_NEW_S: Final = 0.2
"""Time in which questions that were begun are not begun again [s]."""
_FIRST_S: Final = 3.0
"""Longest time until the first ATTITUDE [s]."""


class Learning:
    """The questions to one vehicle."""

    def __init__(self, requests: RequestQueue, parameters: ParameterReads) -> None:
        self._requests, self._parameters = requests, parameters
        self._since = -math.inf
        self._profile: VehicleProfile | None = None
        self._left = 0

    def begin(self, profile: VehicleProfile | None, now: float) -> None:
        """Ask for streams and parameters; earlier questions end, unless they are as new as this."""
        if now - self._since < _NEW_S and profile is self._profile:
            return  # a vehicle is not booted so often
        self._profile = profile
        self._since = now
        self._requests.drop(RequestKind.QUESTION)
        rates = profile.rates if profile is not None else STREAMS
        questions: list[tuple[int, tuple[float, ...]]] = [
            (_REQUEST, (float(BY_NAME[name].number),)) for name in _ASKED_ONCE
        ]
        questions += [
            (_INTERVAL, (float(BY_NAME[name].number), 1e6 / rate)) for name, rate in rates.items()
        ]
        self._left = len(questions)
        for command, parameters in questions:
            self._requests.add(
                VehicleRequest(
                    kind=RequestKind.QUESTION,
                    command=command,
                    parameters=parameters,
                    answered=self._answered,
                )
            )
        if profile is not None:
            self._parameters.begin(profile.parameters, OLDER_NAMES, profile.later)

    def done(self, now: float) -> bool:
        """Whether all was answered, or the time is over."""
        return now - self._since > _LONGEST_S or not (self._left or self._parameters.reading)

    def is_silent(self, measured: float, now: float) -> bool:
        """Whether the telemetry that was asked for does not come.

        Args:
            measured: Monotonic time of the last ATTITUDE [s].
            now: Monotonic time [s].
        """
        return now - max(measured, self._since + _FIRST_S - _SILENT_S) > _SILENT_S

    def _answered(self, _result: int, _now: float) -> None:
        self._left -= 1
