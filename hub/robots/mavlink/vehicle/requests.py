"""Commands that wait for their answers; pure.

| command | event | action |
| --- | --- | --- |
| first in the queue | it is due, tries are left | send it, and again after 0.7 s |
| first | no try is left | it ends: no answer |
| sent | IN_PROGRESS | wait 5 s more |
| sent | TEMPORARILY_REJECTED, tries are left | send it again after 0.5 s |
| sent | another result | it ends with this result |
| not sent | any result | nothing: it is not meant |

An answer names its command only, so only the first one is under way. To disarm comes before all
other orders, and they come before questions.
"""

from __future__ import annotations

import bisect
import enum
from collections.abc import Callable
from typing import Final

from hub.values import dataclass

RESEND_S: Final = 0.7
_IN_PROGRESS_S: Final = 5.0
_REJECTED_S: Final = 0.5
_MOST_QUEUED: Final = 64
ACCEPTED: Final = 0
TEMPORARILY_REJECTED: Final = 1
IN_PROGRESS: Final = 5
NO_ANSWER: Final = -1
"""The result of a command that was not answered."""
RESULTS: Final = {
    NO_ANSWER: "no answer",
    0: "accepted",
    1: "temporarily rejected",
    2: "denied",
    3: "unsupported",
    4: "failed",
    5: "in progress",
    6: "cancelled",
}


class RequestKind(enum.IntEnum):
    """How urgent a command is; the smallest comes first.

    Attributes:
        DISARM: The order to switch the motors off.
        ORDER: Another order of the operator.
        QUESTION: A question of the hub.
    """

    DISARM = 0
    ORDER = 1
    QUESTION = 2


@dataclass(slots=True, kw_only=True, eq=False)
class VehicleRequest:
    """A COMMAND_LONG that waits for its answer.

    Attributes:
        kind: How urgent it is.
        command: Its MAV_CMD.
        parameters: Its parameters, at most seven.
        answered: Called with the result and the monotonic time [s].
        tries: How often it may be sent.
        due: Monotonic time of the next try [s].
        sent: Whether it was sent.
    """

    kind: RequestKind
    command: int
    parameters: tuple[float, ...]
    answered: Callable[[int, float], None]
    tries: int = 3
    due: float = 0.0
    sent: bool = False


class RequestQueue:
    """The commands to one vehicle."""

    def __init__(self) -> None:
        self._queue: list[VehicleRequest] = []

    def __len__(self) -> int:
        return len(self._queue)

    def add(self, request: VehicleRequest) -> None:
        """Queue a command behind those as urgent; a question too many is left out."""
        if request.kind is not RequestKind.QUESTION or len(self._queue) < _MOST_QUEUED:
            bisect.insort(self._queue, request, key=lambda each: each.kind)

    def drop(self, kind: RequestKind) -> None:
        """Drop the commands of a kind; they get no answer."""
        self._queue = [each for each in self._queue if each.kind is not kind]

    def due(self, now: float) -> VehicleRequest | None:
        """The command to send now; None: there is none."""
        while self._queue:
            request = self._queue[0]
            if now < request.due:
                return None
            if request.tries > 0:
                request.tries -= 1
                request.due = now + RESEND_S
                request.sent = True
                return request
            self._queue.pop(0)
            request.answered(NO_ANSWER, now)
        return None

    def answer(self, command: int, result: int, now: float) -> None:
        """Take a COMMAND_ACK."""
        request = next((each for each in self._queue if each.command == command), None)
        if request is None or not request.sent:
            return
        if result == IN_PROGRESS:
            request.due = now + _IN_PROGRESS_S
        elif result == TEMPORARILY_REJECTED and request.tries > 0:
            request.due = now + _REJECTED_S
        else:
            self._queue.remove(request)
            request.answered(result, now)
