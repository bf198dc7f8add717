"""The lease of control: at most one console has control of the robot; pure.

| event | FREE | OWNED, by the owner | OWNED, by another console |
| --- | --- | --- | --- |
| take | it becomes the owner | it stays the owner | refuse |
| ask | it becomes the owner | it stays the owner | queue, at most 8; then refuse |
| take over (needs the right) | it becomes the owner | it stays the owner | it becomes the owner |
| free (needs the right) | - | drop the queue, FREE | drop the queue, FREE |
| release | refuse | NEXT | leave the queue |
| grant | refuse | the first of the queue becomes the owner | refuse |
| deny | refuse | drop the first of the queue | refuse |
| connection ends | - | NEXT | leave the queue |
| silent for `LOST_S` | - | NEXT | leave the queue |
| owner does not answer for `ANSWER_S` | - | drop the first of the queue | - |
| this process paused for over 1 s | - | add the pause to all these times | the same |

NEXT: the first of the queue becomes the owner; if the queue is empty, the robot is FREE.
A console keeps control only while it reports that it has it.
"""

from __future__ import annotations

from hub.gcm.control import ANSWER_S, LOST_S
from hub.own_pauses import OwnPauses
from hub.values import dataclass

MAX_REQUESTS = 8
"""Most requests at a time."""
LONGEST_NAME = 40
"""Most letters of an operator's name."""
STALL_S = 1.0
"""Pause between two checks after which this process counts as paused, not the consoles [s]."""

Answer = tuple[bool, str]
"""Whether the order is done, and a sentence with the result or the reason."""


@dataclass(slots=True, kw_only=True)
class Console:
    """A console that has control or asks for it.

    Attributes:
        number: Its number at central.
        operator: Its operator.
        since: Start of its control, or of its place as the first request [s].
        last_heard: Time of its last heartbeat [s].
    """

    number: int
    operator: str
    since: float
    last_heard: float


class ControlLease:
    """The lease; every method gets the present monotonic time [s].

    Attributes:
        owner: The console with control; None: none.
        requests: The consoles that ask for it; the first awaits the owner's answer.
        why: The reason for the present state, for people.
    """

    def __init__(self, now: float) -> None:
        self.owner: Console | None = None
        self.requests: list[Console] = []
        self.why = "nobody has taken control yet"
        self._pauses = OwnPauses(STALL_S)
        self._pauses.look(now)

    def take(self, number: int, operator: str, now: float) -> Answer:
        """Take control of a free robot."""
        self.expire(now)
        if self.owner is None:
            self._give(number, operator, f"{shown(operator)} took control", now)
            return True, "you have control"
        if self.owner.number == number:
            return True, "you have control already"
        return False, f"{self.owner.operator} has control; ask for it"

    def release(self, number: int, now: float) -> Answer:
        """Give up control, or a request for it."""
        self.expire(now)
        if self.owner is not None and self.owner.number == number:
            self._free(f"{self.owner.operator} gave up control", now)
            return True, "you have given up control"
        if self._asks(number):
            self._remove_request(number, now)
            return True, "you no longer ask for control"
        return False, "you have no control that you could give up"

    def ask(self, number: int, operator: str, now: float) -> Answer:
        """Ask for control: a free robot is taken, another owner is asked."""
        self.expire(now)
        if self.owner is None or self.owner.number == number:
            return self.take(number, operator, now)
        owner_name = self.owner.operator
        if self._asks(number):
            return True, f"you have asked {owner_name} already"
        if len(self.requests) >= MAX_REQUESTS:
            return (
                False,
                f"{MAX_REQUESTS} others ask {owner_name} for control already; try again later",
            )
        self.requests.append(
            Console(number=number, operator=shown(operator), since=now, last_heard=now)
        )
        turns = len(self.requests) - 1
        after = f" after {turns} other{'s' if turns > 1 else ''}" if turns else ""
        return True, f"{owner_name} is asked{after}, and has {ANSWER_S:.0f} s to answer"

    def grant(self, number: int, now: float) -> Answer:
        """Hand control to the first request, as its owner."""
        self.expire(now)
        if refusal := self._no_answer(number):
            return False, refusal
        owner, asker = self.owner, self.requests[0]
        why = f"{owner.operator if owner else ''} handed control to {asker.operator}"
        self._give(asker.number, asker.operator, why, now)
        return True, f"{asker.operator} has control"

    def deny(self, number: int, now: float) -> Answer:
        """Refuse the first request, as the owner."""
        self.expire(now)
        if refusal := self._no_answer(number):
            return False, refusal
        asker, owner = self.requests[0], self.owner
        self.why = f"{owner.operator if owner else ''} did not hand control to {asker.operator}"
        self._remove_request(asker.number, now)
        return True, f"{asker.operator} does not get control"

    def take_over(self, number: int, operator: str, now: float) -> Answer:
        """Take control from any owner; the caller has checked the right."""
        self.expire(now)
        owner = self.owner
        if owner is None or owner.number == number:
            return self.take(number, operator, now)
        why = f"{shown(operator)} took control from {owner.operator}"
        self._give(number, operator, why, now)
        return True, f"you have control; {owner.operator} had it"

    def free(self, now: float) -> Answer:
        """Take control from any owner and free the robot, without its requests."""
        self.expire(now)
        if self.owner is None:
            return True, "nobody had control"
        text = f"control was taken from {self.owner.operator}"
        self.requests.clear()
        self._free(text, now)
        return True, text

    def heartbeat(self, number: int, now: float, *, holds: bool) -> None:
        """Note a heartbeat; the owner keeps control only while its heartbeats claim it."""
        self.expire(now)
        if self.owner is not None and self.owner.number == number and holds:
            self.owner.last_heard = now
        for request in self.requests:
            if request.number == number:
                request.last_heard = now

    def disconnected(self, number: int, now: float) -> None:
        """Note that a console has disconnected."""
        self.expire(now)
        if self.owner is not None and self.owner.number == number:
            self._free(f"the console of {self.owner.operator} has left", now)
        elif self._asks(number):
            self._remove_request(number, now)

    def expire(self, now: float) -> None:
        """Apply the limits of time."""
        if away := self._pauses.look(now):
            self._add_pause(away)
        for request in [each for each in self.requests if now - each.last_heard >= LOST_S]:
            self._remove_request(request.number, now)
        owner = self.owner
        if owner is not None and now - owner.last_heard >= LOST_S:
            self._free(f"the console of {owner.operator} fell silent", now)
        elif owner is not None and self.requests and self.left(now) <= 0.0:
            self.why = f"{owner.operator} did not answer {self.requests[0].operator}"
            self._remove_request(self.requests[0].number, now)

    def left(self, now: float) -> float:
        """The owner's time to answer the first request [s]; 0: there is none."""
        return self.requests[0].since + ANSWER_S - now if self.requests else 0.0

    def _no_answer(self, number: int) -> str:
        """Why a console cannot answer a request; empty: it can."""
        if self.owner is None or self.owner.number != number:
            return "only who has control can hand it over"
        return "" if self.requests else "nobody asks for control"

    def _asks(self, number: int) -> bool:
        return any(request.number == number for request in self.requests)

    def _remove_request(self, number: int, now: float) -> None:
        """Remove a request; after the first, the next one's time begins."""
        first = self.requests[0]
        self.requests = [each for each in self.requests if each.number != number]
        if self.requests and self.requests[0] is not first:
            self.requests[0].since = now

    def _give(self, number: int, operator: str, why: str, now: float) -> None:
        if self._asks(number):
            self._remove_request(number, now)
        self.owner = Console(number=number, operator=shown(operator), since=now, last_heard=now)
        self.why = why
        if self.requests:
            self.requests[0].since = now  # another owner answers now

    def _free(self, why: str, now: float) -> None:
        self.owner, self.why = None, why
        if self.requests:
            first = self.requests[0]
            self._give(first.number, first.operator, f"{why}; {first.operator} had asked", now)

    def _add_pause(self, away: float) -> None:
        """Add a pause of this process to all times: unread heartbeats may wait."""
        for console in (*self.requests, *([self.owner] if self.owner else [])):
            console.last_heard += away
        if self.requests:
            self.requests[0].since += away


def shown(operator: str) -> str:
    """An operator's name without control characters."""
    name = "".join(letter for letter in operator if letter.isprintable()).strip()
    return name[:LONGEST_NAME] or "somebody"
