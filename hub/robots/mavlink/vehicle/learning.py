"""What a vehicle is asked when it is heard, and whether it answered; pure.

A question without an answer is asked again, behind the others, ten times: a link may lose some.

| a vehicle that was gone answers again | next |
| --- | --- |
| it was not learnt, or has started since | ask for everything |
| its telemetry comes | go on: it was not booted |
| its telemetry does not come within 1.5 s | ask for everything |
"""

from __future__ import annotations

import enum
import functools
import math
from typing import Final, TypeAlias

from hub.robots.mavlink.profiles.profile import OLDER_NAMES, STREAMS, VehicleProfile
from hub.robots.mavlink.vehicle.parameter_reads import ParameterReads
from hub.robots.mavlink.vehicle.requests import (
    NO_ANSWER,
    RequestKind,
    RequestQueue,
    VehicleRequest,
)
from hub.robots.mavlink.vehicle.sender import VehicleSender
from hub.robots.mavlink.wire.definitions import BY_NAME

_INTERVAL: Final = 511
"""MAV_CMD_SET_MESSAGE_INTERVAL."""
_REQUEST: Final = 512
"""MAV_CMD_REQUEST_MESSAGE."""
_ASKED_ONCE: Final = ("AUTOPILOT_VERSION", "GPS_GLOBAL_ORIGIN", "GPS_RAW_INT")
_ROUNDS: Final = 10
"""How often a question without an answer is asked again."""
_LONGEST_S: Final = 4.0
"""Longest time to wait for the answers [s]."""
_SILENT_S: Final = 1.5
"""Time without ATTITUDE after which telemetry is silent [s]."""
_NEW_S: Final = 0.2
"""Time in which questions that were begun are not begun again [s]."""
_FIRST_S: Final = 3.0
"""Longest time until the first ATTITUDE [s]."""


_Question: TypeAlias = tuple[int, tuple[float, ...]]
"""A command and its parameters."""


class Return(enum.Enum):
    """What to do with a vehicle that answers again.

    Attributes:
        WAIT: Wait for its telemetry.
        GO_ON: Go on; it is known.
        LEARN: Ask for everything.
    """

    WAIT = enum.auto()
    GO_ON = enum.auto()
    LEARN = enum.auto()


class Learning:
    """The questions to one vehicle; times are monotonic [s].

    Attributes:
        because: Why it is asked for everything; empty: it is heard for the first time.
        learnt: Whether it was asked for everything since its last start.
    """

    def __init__(self, requests: RequestQueue, parameters: ParameterReads) -> None:
        self._requests, self._parameters = requests, parameters
        self.because, self.learnt = "", False
        self._since = self._back_at = -math.inf
        self._profile: VehicleProfile | None = None
        self._rounds: dict[_Question, int] = {}

    def forget(self, because: str) -> None:
        """It has to be asked for everything again, as soon as it is there."""
        self.because, self.learnt = because, False

    def gone(self) -> None:
        """It is gone; its questions end."""
        self._back_at = math.inf
        self._requests.drop(RequestKind.QUESTION)

    def back(self, measured: float, now: float) -> Return:
        """It answers again.

        Args:
            measured: Time of the last ATTITUDE.
            now: The time.
        """
        self._back_at = min(self._back_at, now)
        if not self.learnt:
            return Return.LEARN
        if measured > now - _SILENT_S:
            return Return.GO_ON
        return Return.LEARN if now - self._back_at > _SILENT_S else Return.WAIT

    def send(self, sender: VehicleSender, now: float, *, reads: bool) -> None:
        """Send what is due; `reads`: parameters too."""
        if (request := self._requests.due(now)) is not None:
            sender.command(request)
        if reads and (name := self._parameters.due(now)):
            sender.message("PARAM_REQUEST_READ", param_index=-1, param_id=name)

    def begin(self, profile: VehicleProfile | None, now: float) -> None:
        """Ask for streams and parameters; earlier questions end, unless they are as new as this."""
        if now - self._since < _NEW_S and profile is self._profile:
            return  # a vehicle is not booted so often
        self._profile = profile
        self._since = now
        rates = profile.rates if profile is not None else STREAMS
        questions: list[_Question] = [
            (_INTERVAL, (float(BY_NAME[name].number), 1e6 / rate)) for name, rate in rates.items()
        ]
        questions += [(_REQUEST, (float(BY_NAME[name].number),)) for name in _ASKED_ONCE]
        self._rounds = dict.fromkeys(questions, _ROUNDS)
        self.go_on()

    def go_on(self) -> None:
        """Ask what has no answer yet, and read the parameters again, which may have changed."""
        self._requests.drop(RequestKind.QUESTION)
        for each in self._rounds:
            self._ask(each)
        if self._profile is not None:
            profile = self._profile
            self._parameters.begin(profile.parameters, OLDER_NAMES, profile.later)

    def done(self, now: float) -> bool:
        """Whether all was answered, or the time is over."""
        return now - self._since > _LONGEST_S or not (self._rounds or self._parameters.reading)

    def is_silent(self, measured: float, now: float) -> bool:
        """Whether the telemetry that was asked for does not come.

        Args:
            measured: Monotonic time of the last ATTITUDE [s].
            now: Monotonic time [s].
        """
        return now - max(measured, self._since + _FIRST_S - _SILENT_S) > _SILENT_S

    def _ask(self, question: _Question) -> None:
        command, parameters = question
        self._requests.add(
            VehicleRequest(
                kind=RequestKind.QUESTION,
                command=command,
                parameters=parameters,
                answered=functools.partial(self._answered, question),
            )
        )

    def _answered(self, question: _Question, result: int, _now: float) -> None:
        left = self._rounds.pop(question, 0)
        if result == NO_ANSWER and left > 1:
            self._rounds[question] = left - 1
            self._ask(question)
