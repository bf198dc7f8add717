"""Recordings as frames at equal distances of time: the state of each robot then, in any layout.

So recordings of hubs are shown, which have no frames, and those of consoles in another layout.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, Protocol

from hub.recording.anchor import TimeAnchor
from hub.recording.holes import beyond_hole
from hub.recording.reader import LoggedMessage
from hub.recording.recording_set import RecordingSet
from rune_tui.errors import LogError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.replay.source import Overview, ReplayFrame
from rune_tui.replay.survey import survey

PERIOD_NS: Final = 50_000_000
"""Time between two frames [ns]."""


class RobotOfLog(Protocol):
    """A robot of a recording; it goes on message by message."""

    def seek(self, stamp: int) -> None:
        """Go to a time [ns]: take the newest of each message at or before it."""

    def take(self, message: LoggedMessage) -> None:
        """Take the next message of the recording, of any robot."""

    def state(self, role: str) -> RobotState:
        """Its state now, under its name in the layout."""


class TimedLog:
    """States of robots by time; see `ReplaySource`."""

    def __init__(
        self,
        recording: RecordingSet,
        layout: LayoutSpec,
        robots: Mapping[str, RobotOfLog],
        anchor: TimeAnchor,
        faults: list[str],
    ) -> None:
        """Prepare.

        Args:
            recording: The files; closed with this.
            layout: Shows them.
            robots: The robots by their names in the layout.
            anchor: The clock that the robots' times of measurement follow.
            faults: What cannot be shown; the robots add to it.

        Raises:
            LogError: The recording has no messages.
        """
        if not recording.end:
            reason = f"{recording.path} has no messages that can be read"
            raise LogError(reason)
        files = len(recording.recordings)
        self.title = recording.path.name + (f" and {files - 1} more" if files > 1 else "")
        self._faults = faults
        self.start = recording.start
        self.holes = recording.holes
        self.end = self.start + (recording.end - self.start) // PERIOD_NS * PERIOD_NS
        self._recording = recording
        self._layout = layout
        self._robots = robots
        self._anchor = anchor
        self._begin = ConsoleState.at_start(layout, 0.0)
        self._at = -1

    @property
    def faults(self) -> list[str]:
        """What cannot be shown, and why."""
        return [*self._recording.faults, *self._faults]

    def frames(self, after: int, until: int, apart: int = 0) -> Iterator[ReplayFrame]:
        """Some or all frames, in the order of time; see `ReplaySource`."""
        if self._at != after:
            for robot in self._robots.values():
                robot.seek(after)
        left_out = max(0, apart - 1)
        due = self.frame_after(after + left_out)
        last = min(until, self.end)
        for message in self._recording.messages(after + 1, last):
            while due is not None and due < message.stamp:
                self._at = due
                yield self._frame(due)
                due = self.frame_after(due + left_out)
            for robot in self._robots.values():
                robot.take(message)
        while due is not None and due <= last:
            self._at = due
            yield self._frame(due)
            due = self.frame_after(due + left_out)
        self._at = until

    def frame_before(self, stamp: int) -> int | None:
        """Stamp of the newest frame at or before a time; None: there is none."""
        if stamp < self.start:
            return None
        return self.start + (min(stamp, self.end) - self.start) // PERIOD_NS * PERIOD_NS

    def frame_after(self, stamp: int) -> int | None:
        """Stamp of the first frame later than a time; None: there is none."""
        if stamp < self.start:
            return self.start
        found = self._frame_at(stamp + 1)
        found = self._frame_at(beyond_hole(self.holes, found))
        return found if found <= self.end else None

    def _frame_at(self, stamp: int) -> int:
        """The first moment of frames at or after a time."""
        return stamp + (self.start - stamp) % PERIOD_NS

    def press(self, _key: str, _stamp: int) -> bool:
        """No key means anything."""
        return False

    def check(self, seconds: float) -> None:
        """Look for damage for a time [s]; `faults` has it."""
        self._recording.check(seconds)

    def overview(self) -> Overview:
        """What happened."""
        return survey(self._recording)

    def close(self) -> None:
        """Close the files."""
        self._recording.close()

    def _frame(self, stamp: int) -> ReplayFrame:
        robots = {role: robot.state(role) for role, robot in self._robots.items()}
        now = self._anchor.moment(stamp)
        clock = time.strftime("%H:%M:%S", time.localtime(stamp / 1e9))
        state = dataclasses.replace(self._begin, now=now, clock=clock, robots=robots)
        return ReplayFrame(stamp=stamp, state=state, layout=self._layout, slow={})


def paired(roles: Sequence[str], names: Mapping[str, str]) -> dict[str, str]:
    """The recorded robot of each role of a layout.

    Args:
        roles: Names in the layout.
        names: The recorded robots: names in topics, and the robot's own; empty: not known.

    Returns:
        Names in topics by role: equal names first, then in order.
    """
    found: dict[str, str] = {}
    for role in roles:
        same = [name for name, own in names.items() if role in (name, own)]
        if same and same[0] not in found.values():
            found[role] = same[0]
    left = iter([name for name in names if name not in found.values()])
    for role in roles:
        if role not in found:
            name = next(left, None)
            if name is not None:
                found[role] = name
    return found
