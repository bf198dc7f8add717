"""Which inputs were down, and for how long, from their records; pure.

| what a record says | what follows |
| --- | --- |
| a press | the input is down from then on |
| a repeat of an input that is up | the same: its press was not seen |
| a release | it was down up to then |
| a press of an input that is down | its release was lost: it was down up to its last record |
| the terminal loses the focus | all keys go up: their releases do not arrive |
| a press while control is withheld | the input is down, and does not count |
| nothing more | it was down up to the end, if its last press acted and no release was lost before |
| nothing more of another one | it was down up to its last record |

A wheel, a ball and a moving mouse are never released, and never down.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub.values import dataclass
from rune_tui.layout.names import MOUSE
from rune_tui.model.own_records import InputOutcome, InputRecord

_MOMENTARY: Final = (MOUSE + "wheel", MOUSE + "motion")


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldSpan:
    """A time in which an input was down.

    Attributes:
        robot: The robot that it commands.
        begin: When it went down, in the unit of the records' times.
        end: When it went up.
    """

    robot: str
    begin: float
    end: float


@dataclass(slots=True)
class _Down:
    robot: str
    begin: float
    last: float
    acts: bool
    counts: bool


class HeldInputs:
    """Follows the inputs of a recording from its begin on.

    Attributes:
        spans: Those that are over, in the order of their ends.
    """

    def __init__(self) -> None:
        """Start without inputs."""
        self.spans: list[HeldSpan] = []
        self._down: dict[str, _Down] = {}
        self._unreleased: set[str] = set()

    def take(self, moment: float, record: InputRecord) -> None:
        """Take a record; times must ascend."""
        name = record.input
        if name in _MOMENTARY:
            return
        if not record.pressed:
            self._end(name, moment)
            return
        acts = record.outcome is not InputOutcome.DEAF
        down = self._down.get(name)
        if down is not None and record.repeat:
            down.last, down.acts = moment, acts
            return
        if down is not None:
            self._unreleased.add(name)
            self._end(name, down.last)
        self._down[name] = _Down(
            robot=record.robot if record.handlers else "",
            begin=moment,
            last=moment,
            acts=acts,
            counts=record.outcome is not InputOutcome.WITHHELD,
        )

    def withheld(self, name: str) -> bool:
        """Whether an input is down, and was pressed while control was withheld."""
        down = self._down.get(name)
        return down is not None and not down.counts

    def focus_lost(self, moment: float) -> None:
        """Take that releases of keys do not arrive any more."""
        for name in tuple(self._down):
            self._end(name, moment)

    def until(self, end: float) -> Iterator[HeldSpan]:
        """All spans; inputs that are still down count up to `end` if they acted."""
        yield from self.spans
        for name, down in self._down.items():
            stays = down.acts and name not in self._unreleased
            yield from _span(down, max(end, down.last) if stays else down.last)

    def _end(self, name: str, moment: float) -> None:
        down = self._down.pop(name, None)
        if down is not None:
            self.spans += _span(down, moment)


def _span(down: _Down, end: float) -> Iterator[HeldSpan]:
    if down.robot and down.counts and end > down.begin:
        yield HeldSpan(robot=down.robot, begin=down.begin, end=end)
