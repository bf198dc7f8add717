"""Whether a layout wants the capabilities behind its viewports and widgets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from hub.gcm.providers import PROVIDED_BY, TAKEN_BY
from rune_tui.layout.grammar import Mistake, Node, Rules, quoted
from rune_tui.layout.names import CAPABILITY_INTERVALS_MS
from rune_tui.layout.places import Place
from rune_tui.layout.spec import CHOSEN


class Wants:
    """The capabilities that a layout wants of each robot."""

    def __init__(self, robots: Iterable[Node], rules: Rules) -> None:
        self._of: dict[str, set[str]] = {}
        for robot in robots:
            wanted = {rules.value(node, "name") or "" for node in robot.of("capability")}
            if not wanted <= CAPABILITY_INTERVALS_MS.keys():
                self._of.clear()  # one that is misspelt could be any
                return
            self._of.setdefault(rules.value(robot, "name") or "", set()).update(wanted)
        self._of[CHOSEN] = set().union(*self._of.values())

    def undrawn(
        self, message: str, function: str, robot: str | None, place: Place
    ) -> Iterator[Mistake]:
        """Report a visualizer whose messages no wanted capability publishes."""
        if not self._met([message], robot, PROVIDED_BY):
            what = f"{function} draws {message}, which no wanted capability"
            yield self._mistake(place, what, "brings", robot, PROVIDED_BY[message][0])

    def unheard(
        self, messages: Iterable[str], handler: str, robot: str | None, place: Place
    ) -> Iterator[Mistake]:
        """Report a widget whose messages no wanted capability receives."""
        if not self._met(messages, robot, TAKEN_BY):
            first = next(name for name in messages if name in TAKEN_BY)
            what = f"{handler} sends {first}, which no wanted capability"
            yield self._mistake(place, what, "takes", robot, TAKEN_BY[first][0])

    def _met(
        self, messages: Iterable[str], robot: str | None, table: Mapping[str, tuple[str, ...]]
    ) -> bool:
        """Whether one of the messages has its capability, or needs none; unknown robots have."""
        known = [table[message] for message in messages if message in table]
        if not known or robot is None or robot not in self._of:
            return True
        return any(self._of[robot].intersection(capabilities) for capabilities in known)

    def _mistake(
        self, place: Place, what: str, does: str, robot: str | None, missing: str
    ) -> Mistake:
        whom = "of any robot" if robot == CHOSEN else f"of robot {quoted(robot or '')}"
        return Mistake(place, f'{what} {whom} {does}; add <capability name="{missing}"/> to it')
