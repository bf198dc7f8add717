"""Commands that wait for their answers, and parameters that are read by name; pure.

| command | event | action |
| --- | --- | --- |
| first in the queue | it is due, tries are left | send it, and again after 0.7 s |
| first | no try is left | it ends: no answer |
| first | IN_PROGRESS | wait 5 s more |
| first | TEMPORARILY_REJECTED, tries are left | send it again after 0.5 s |
| first | another result | it ends with this result |

One command is under way at a time: an answer names its command only.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable
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
_READ_EVERY_S: Final = 0.05
"""Time between two reads of parameters [s]."""
_READ_TRIES: Final = 4


@dataclass(slots=True, kw_only=True, eq=False)
class VehicleRequest:
    """A COMMAND_LONG that waits for its answer.

    Attributes:
        command: Its MAV_CMD.
        parameters: Its parameters, at most seven.
        answered: Called with the result and the monotonic time [s].
        tries: How often it may be sent.
        due: Monotonic time of the next try [s].
    """

    command: int
    parameters: tuple[float, ...]
    answered: Callable[[int, float], None]
    tries: int = 3
    due: float = 0.0


class RequestQueue:
    """The commands to one vehicle, in their order."""

    def __init__(self) -> None:
        self._queue: deque[VehicleRequest] = deque()

    def __len__(self) -> int:
        return len(self._queue)

    def add(self, request: VehicleRequest, *, first: bool = False) -> None:
        """Queue a command; `first` puts it before all others, in place of the one under way."""
        if first:
            self._queue.appendleft(request)
        elif len(self._queue) < _MOST_QUEUED:
            self._queue.append(request)

    def drop(self, commands: Iterable[int] = ()) -> None:
        """Drop the commands of these numbers without an answer; none: all."""
        wanted = set(commands)
        kept = [each for each in self._queue if wanted and each.command not in wanted]
        self._queue = deque(kept)

    def due(self, now: float) -> VehicleRequest | None:
        """The command to send now; None: there is none."""
        while self._queue:
            request = self._queue[0]
            if now < request.due:
                return None
            if request.tries > 0:
                request.tries -= 1
                request.due = now + RESEND_S
                return request
            self._queue.popleft()
            request.answered(NO_ANSWER, now)
        return None

    def answer(self, command: int, result: int, now: float) -> None:
        """Take a COMMAND_ACK; one of another command changes nothing."""
        if not self._queue or self._queue[0].command != command:
            return
        request = self._queue[0]
        if result == IN_PROGRESS:
            request.due = now + _IN_PROGRESS_S
        elif result == TEMPORARILY_REJECTED and request.tries > 0:
            request.due = now + _REJECTED_S
        else:
            self._queue.popleft()
            request.answered(result, now)


class ParameterReads:
    """Parameters that are read by name; a vehicle does not answer names that it does not have."""

    def __init__(self) -> None:
        self.values: dict[str, float] = {}
        self._left: deque[str] = deque()
        self._tries: dict[str, int] = {}
        self._at = -math.inf

    @property
    def reading(self) -> bool:
        """Whether some are still read."""
        return bool(self._left)

    def begin(self, names: Iterable[str]) -> None:
        """Read these again."""
        self._left = deque(dict.fromkeys(names))
        self._tries = dict.fromkeys(self._left, _READ_TRIES)

    def due(self, now: float) -> str:
        """The name to ask for now; empty: none."""
        if not self._left or now - self._at < _READ_EVERY_S:
            return ""
        self._at = now
        name = self._left.popleft()
        self._tries[name] -= 1
        if self._tries[name] > 0:
            self._left.append(name)
        return name

    def take(self, name: str, value: float) -> None:
        """Take a PARAM_VALUE; others than the wanted ones are left out."""
        if name in self._tries and math.isfinite(value):
            self.values[name] = value
            if name in self._left:
                self._left.remove(name)
