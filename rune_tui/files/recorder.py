"""Records messages from and to robots, and the state of the terminal's picture."""

from __future__ import annotations

import datetime
import functools
import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from hub.gcm.body import ROBOT_DESCRIPTION
from rune_tui.files import user_files
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.robot_link import RobotLink
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.display_state import RUNE_DISPLAY, DisplayState
from rune_tui.model.robot_state import titles
from rune_tui.model.shown_layout import SHOWN_LAYOUT, ShownLayout
from rune_tui.model.team_events import RUNE_TEAM, TeamEvent

if TYPE_CHECKING:
    from rune_tui.export.recording import Recording

_DISPLAY_S = 1.0
"""Period of the records of the display's state [s]."""
_OWN = "console"
"""Name in place of a robot's, for messages of the console itself."""


class Recorder:
    """Begins and ends recordings; for the console's own thread only."""

    def __init__(self, links: RobotLinks) -> None:
        self._links = links
        self._recording: Recording | None = None
        self._noted = 0.0

    @property
    def path(self) -> str:
        """The file of the running recording; else empty."""
        return str(self._recording.path) if self._recording is not None else ""

    def begin(self, layout: LayoutSpec, operator: str) -> user_files.Outcome:
        """Begin a recording; returns the outcome."""
        now = datetime.datetime.now().astimezone()
        self._recording, said = user_files.begin_recording(layout, operator, now)
        self.follow(layout)
        for link in self._links.values():
            described = link.state.newest(ROBOT_DESCRIPTION)
            if described is not None:  # its only message came before the recording
                link.record(ROBOT_DESCRIPTION, described.value, described.measured)
        return said

    def follow(self, layout: LayoutSpec) -> None:
        """Record another layout and all present links, with the time of the change."""
        self._tap()
        if self._recording is not None:
            shown = ShownLayout(layout=layout.path, run=layout.run_number)
            self._recording.add(_OWN, SHOWN_LAYOUT, shown, time.monotonic())

    def end(self) -> Callable[[], user_files.Outcome]:
        """Stop to record; returns the slow rest of the work."""
        recording, self._recording = self._recording, None
        self._tap()
        if recording is None:
            return lambda: user_files.Outcome(text="nothing was being recorded")
        return lambda: user_files.end_recording(recording)

    def _tap(self) -> None:
        """Connect all links, also new ones, to the recording."""
        names = _names(self._links.values())
        for link, name in zip(self._links.values(), names, strict=True):
            add = self._recording.add if self._recording is not None else None
            link.tap(functools.partial(add, name) if add is not None else None)

    def note_team(self, now: float, event: TeamEvent) -> None:
        """Record what the operator did with the robots."""
        if self._recording is not None:
            self._recording.add(_OWN, RUNE_TEAM, event, now)

    def note(self, now: float, display: DisplayState) -> None:
        """Record the display's state once a second."""
        if self._recording is not None and now - self._noted >= _DISPLAY_S:
            self._noted = now
            self._recording.add(_OWN, RUNE_DISPLAY, display, now)


def _names(links: Iterable[RobotLink]) -> list[str]:
    """Names of robots in a recording: as on the screen, without `/`."""
    called = titles(link.state for link in links)
    return [name if "/" not in name else role for role, name in called.items()]
