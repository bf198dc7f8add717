"""What a study of an operator with several robots needs, with its time: choices and answers; pure.

| event | meaning | `after_s` is the time since |
| --- | --- | --- |
| CHOSEN | the robot is the chosen one now | the choice before |
| PEEKED | the operator looks at it without taking it | the choice |
| COMMANDED | the first command to the chosen robot | the choice |
| RAISED | an alarm or warning is raised, or raised again | it was raised first |
| ANSWERED | the operator looks at its robot | it was raised last |
| OVER | the problem has ended | it was raised first |
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator

from hub.gcm.fields import Name
from hub.ipc.definition import MessageDefinition
from hub.values import dataclass
from rune_tui.model.attention import AttentionEntry
from rune_tui.model.console_state import ConsoleState


class TeamEventKind(enum.IntEnum):
    """The kinds of events, as the table of the module says."""

    CHOSEN = 0
    PEEKED = 1
    COMMANDED = 2
    RAISED = 3
    ANSWERED = 4
    OVER = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamEvent:
    """One event.

    Attributes:
        kind: Its kind.
        robot: The robot's name in the layout.
        cause: The cause of an alarm or warning; else empty.
        after_s: The time that the table of the module names [s]; NaN: there is none.
    """

    kind: TeamEventKind
    robot: Name
    cause: Name = ""
    after_s: float = math.nan


RUNE_TEAM = MessageDefinition(
    name="RuneTeam",
    type=TeamEvent,
)
"""A local message: it is recorded, and goes over no bus."""


class TeamWatch:
    """Compares the console's state with its state before."""

    def __init__(self) -> None:
        self._chosen = ""
        self._peeked = ""
        self._since = math.nan
        self._commanded = True
        """Whether the chosen robot got a command since its choice."""
        self._entries: dict[tuple[str, str], AttentionEntry] = {}

    def look(self, state: ConsoleState) -> Iterator[TeamEvent]:
        """The events since the last call."""
        if state.chosen != self._chosen:
            after = state.now - self._since
            self._chosen, self._since, self._commanded = state.chosen, state.now, False
            yield TeamEvent(kind=TeamEventKind.CHOSEN, robot=state.chosen, after_s=after)
        if state.peeked != self._peeked:
            self._peeked = state.peeked
            if state.peeked:
                after = state.now - self._since
                yield TeamEvent(kind=TeamEventKind.PEEKED, robot=state.peeked, after_s=after)
        yield from self._alarms(state)

    def awaits_command(self, chosen: str) -> bool:
        """Whether the chosen robot has got no command since its choice."""
        return chosen != self._chosen or not self._commanded

    def command(self, robot: str, state: ConsoleState) -> Iterator[TeamEvent]:
        """The events, with that of a command to a robot if it is the first since its choice."""
        yield from self.look(state)
        if robot == self._chosen and not self._commanded:
            self._commanded = True
            after = state.now - self._since
            yield TeamEvent(kind=TeamEventKind.COMMANDED, robot=robot, after_s=after)

    def _alarms(self, state: ConsoleState) -> Iterator[TeamEvent]:
        there = {(entry.robot, entry.cause): entry for entry in state.attention if not entry.over}
        before, self._entries = self._entries, there
        for key, entry in there.items():
            known = before.get(key)
            if known is None or known.raised != entry.raised:
                again = entry.raised - entry.since
                yield _of(entry, TeamEventKind.RAISED, again)
            if entry.answered and (known is None or not known.answered):
                yield _of(entry, TeamEventKind.ANSWERED, state.now - entry.raised)
        for key, entry in before.items():
            if key not in there:
                yield _of(entry, TeamEventKind.OVER, state.now - entry.since)


def _of(entry: AttentionEntry, kind: TeamEventKind, after: float) -> TeamEvent:
    return TeamEvent(kind=kind, robot=entry.robot, cause=entry.cause, after_s=after)
