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

from dataclasses import dataclass

from hub.gcm.control import ANSWER_S, LOST_S
from hub.own_pauses import OwnPauses

MOST_REQUESTS = 8
"""How many may ask at a time."""
LONGEST_NAME = 40
"""Letters of an operator's name."""
STALL_S = 1.0
"""A longer pause between two looks means that we were away ourselves, not the consoles [s]."""

Answer = tuple[bool, str]
"""Whether it is done, and in words what was done or why not."""


@dataclass(slots=True, kw_only=True)
class Console:
    """One that has control or asks for it.

    Attributes:
        number: Its number at central.
        operator: Who sits there.
        since: Since when it has control, or has been the first to ask [s].
        heard: When it was heard last [s].
    """

    number: int
    operator: str
    since: float
    heard: float


class ControlLease:
    """Decides; every method gets the present monotonic time [s].

    Attributes:
        owner: Who has control; None: nobody.
        requests: Who asks for it; the first is before the owner, since `since`.
        why: How control came to be as it is, for people.
    """

    def __init__(self, now: float) -> None:
        self.owner: Console | None = None
        self.requests: list[Console] = []
        self.why = "nobody has taken control yet"
        self._pauses = OwnPauses(STALL_S)
        self._pauses.look(now)

    def take(self, number: int, operator: str, now: float) -> Answer:
        """Somebody wants control of a robot that nobody has."""
        self.look(now)
        if self.owner is None:
            self._give(number, operator, f"{shown(operator)} took control", now)
            return True, "you have control"
        if self.owner.number == number:
            return True, "you have control already"
        return False, f"{self.owner.operator} has control; ask for it"

    def release(self, number: int, now: float) -> Answer:
        """Somebody gives up control, or no longer asks for it."""
        self.look(now)
        if self.owner is not None and self.owner.number == number:
            self._free(f"{self.owner.operator} gave up control", now)
            return True, "you have given up control"
        if self._asks(number):
            self._withdraw(number, now)
            return True, "you no longer ask for control"
        return False, "you have no control that you could give up"

    def ask(self, number: int, operator: str, now: float) -> Answer:
        """Somebody wants control, whoever has it; if somebody else has it, they are asked."""
        self.look(now)
        if self.owner is None or self.owner.number == number:
            return self.take(number, operator, now)
        whom = self.owner.operator
        if self._asks(number):
            return True, f"you have asked {whom} already"
        if len(self.requests) >= MOST_REQUESTS:
            return False, f"{MOST_REQUESTS} others ask {whom} for control already; try again later"
        self.requests.append(Console(number=number, operator=shown(operator), since=now, heard=now))
        turns = len(self.requests) - 1
        after = f" after {turns} other{'s' if turns > 1 else ''}" if turns else ""
        return True, f"{whom} is asked{after}, and has {ANSWER_S:.0f} s to answer"

    def grant(self, number: int, now: float) -> Answer:
        """The owner hands control to who asks."""
        self.look(now)
        if refusal := self._no_answer(number):
            return False, refusal
        owner, asker = self.owner, self.requests[0]
        why = f"{owner.operator if owner else ''} handed control to {asker.operator}"
        self._give(asker.number, asker.operator, why, now)
        return True, f"{asker.operator} has control"

    def deny(self, number: int, now: float) -> Answer:
        """The owner keeps control."""
        self.look(now)
        if refusal := self._no_answer(number):
            return False, refusal
        asker, owner = self.requests[0], self.owner
        self.why = f"{owner.operator if owner else ''} did not hand control to {asker.operator}"
        self._withdraw(asker.number, now)
        return True, f"{asker.operator} does not get control"

    def take_over(self, number: int, operator: str, now: float) -> Answer:
        """Somebody who may takes control, whoever has it."""
        self.look(now)
        owner = self.owner
        if owner is None or owner.number == number:
            return self.take(number, operator, now)
        why = f"{shown(operator)} took control from {owner.operator}"
        self._give(number, operator, why, now)
        return True, f"you have control; {owner.operator} had it"

    def free(self, now: float) -> Answer:
        """Somebody who may takes control from whoever has it; those who ask do not get it."""
        self.look(now)
        if self.owner is None:
            return True, "nobody had control"
        text = f"control was taken from {self.owner.operator}"
        self.requests.clear()
        self._free(text, now)
        return True, text

    def heard(self, number: int, now: float, *, holds: bool) -> None:
        """A console lives; that of the owner keeps control only if it knows that it has it."""
        self.look(now)
        if self.owner is not None and self.owner.number == number and holds:
            self.owner.heard = now
        for request in self.requests:
            if request.number == number:
                request.heard = now

    def gone(self, number: int, now: float) -> None:
        """A console has left."""
        self.look(now)
        if self.owner is not None and self.owner.number == number:
            self._free(f"the console of {self.owner.operator} has left", now)
        elif self._asks(number):
            self._withdraw(number, now)

    def look(self, now: float) -> None:
        """Time has gone by."""
        if away := self._pauses.look(now):
            self._forgive(away)
        for request in [each for each in self.requests if now - each.heard >= LOST_S]:
            self._withdraw(request.number, now)
        owner = self.owner
        if owner is not None and now - owner.heard >= LOST_S:
            self._free(f"the console of {owner.operator} fell silent", now)
        elif owner is not None and self.requests and self.left(now) <= 0.0:
            self.why = f"{owner.operator} did not answer {self.requests[0].operator}"
            self._withdraw(self.requests[0].number, now)

    def left(self, now: float) -> float:
        """How long the owner has to answer who asks [s]; 0 if nobody does."""
        return self.requests[0].since + ANSWER_S - now if self.requests else 0.0

    def _no_answer(self, number: int) -> str:
        """Why somebody has nothing to answer; empty if there is something."""
        if self.owner is None or self.owner.number != number:
            return "only who has control can hand it over"
        return "" if self.requests else "nobody asks for control"

    def _asks(self, number: int) -> bool:
        return any(request.number == number for request in self.requests)

    def _withdraw(self, number: int, now: float) -> None:
        """Somebody does not ask any more; if that was the first, the next one's time begins."""
        first = self.requests[0]
        self.requests = [each for each in self.requests if each.number != number]
        if self.requests and self.requests[0] is not first:
            self.requests[0].since = now

    def _give(self, number: int, operator: str, why: str, now: float) -> None:
        if self._asks(number):
            self._withdraw(number, now)
        self.owner = Console(number=number, operator=shown(operator), since=now, heard=now)
        self.why = why
        if self.requests:
            self.requests[0].since = now  # another one is to answer now

    def _free(self, why: str, now: float) -> None:
        self.owner, self.why = None, why
        if self.requests:
            first = self.requests[0]
            self._give(first.number, first.operator, f"{why}; {first.operator} had asked", now)

    def _forgive(self, away: float) -> None:
        """What came meanwhile is still to be read: nobody was silent, and no time ran out."""
        for console in (*self.requests, *([self.owner] if self.owner else [])):
            console.heard += away
        if self.requests:
            self.requests[0].since += away


def shown(operator: str) -> str:
    """An operator's name as all may see it."""
    name = "".join(letter for letter in operator if letter.isprintable()).strip()
    return name[:LONGEST_NAME] or "somebody"
