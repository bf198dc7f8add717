"""Lines of the page of messages, newest first."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.notices import merged
from rune_tui.overlays.help_page import PageLine
from rune_tui.visualizers.parts.severity import Severity

CLOCK_COLUMNS = 8
"""Width of the time of day."""


def log_lines(state: ConsoleState, *, search: str, right: int) -> Iterator[PageLine]:
    """The lines of the page of messages.

    Args:
        state: The console's state, with the messages.
        search: Text that a message must contain.
        right: Width of the column of messages [cells].
    """
    wanted = search.casefold()
    for notice in reversed(merged(state.notices)):
        whom = f"{state.title(notice.robot)}:" if notice.robot else ""
        words = " ".join(filter(None, ("!" if notice.alarm else "", whom, notice.text)))
        if wanted not in f"{notice.clock} {words}".casefold():
            continue
        severity = Severity.ALARM if notice.alarm else Severity.PLAIN
        for number, line in enumerate(textwrap.wrap(words, right) or [""]):
            yield PageLine(left="" if number else notice.clock, right=line, severity=severity)
