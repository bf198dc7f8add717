"""Plays a recording: where it is, how fast it goes, and which frame is shown; pure.

A frame is drawn from what the view remembers of the frames before. So the player keeps copies of
the view, `EVERY_NS` apart, and goes to a time from the last copy before it. Where there is no copy
near, it takes the frames of the last `WARM_NS`; then `since` says from when on it remembers, until
`prepare` gets there.
"""

from __future__ import annotations

import bisect
import math
from collections import OrderedDict, deque
from collections.abc import Callable, Iterator
from typing import Final

from rune_tui.compositor.cells import Cells
from rune_tui.replay.drawing import FrameDrawer
from rune_tui.replay.source import Overview, ReplayFrame, ReplaySource

EVERY_NS: Final = 3_000_000_000
"""Log time between two copies of the view [ns]."""
WARM_NS: Final = 3_000_000_000
"""Log time of the frames that are taken where there is no copy [ns]."""
SLOWEST: Final = 0.1
FASTEST: Final = 100.0
_RATES: Final = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
_NEAR: Final = 15
"""Frames between two copies on the way back."""
_MOST_NEAR: Final = 40
_MEASURED_S: Final = 1.0
_SECOND: Final = 1_000_000_000


class Memory:
    """Copies of a drawer by the time of their last frame."""

    def __init__(self) -> None:
        self._stamps: list[int] = []
        self._drawers: list[FrameDrawer] = []
        self._near: OrderedDict[int, FrameDrawer] = OrderedDict()

    def keep(self, stamp: int, drawer: FrameDrawer) -> None:
        """Keep a copy of a drawer that remembers all frames up to a time."""
        place = bisect.bisect_left(self._stamps, stamp - EVERY_NS + 1)
        if place == len(self._stamps) or self._stamps[place] >= stamp + EVERY_NS:
            place = bisect.bisect_left(self._stamps, stamp)
            self._stamps.insert(place, stamp)
            self._drawers.insert(place, drawer.copied())

    def keep_near(self, stamp: int, drawer: FrameDrawer) -> None:
        """Keep one for the frames that follow it, which are asked for next."""
        self._near[stamp] = drawer.copied()
        while len(self._near) > _MOST_NEAR:
            self._near.popitem(last=False)

    def before(self, stamp: int) -> tuple[int, FrameDrawer] | None:
        """The last copy at or before a time, and its time; None: there is none."""
        place = bisect.bisect_right(self._stamps, stamp) - 1
        found = (self._stamps[place], self._drawers[place]) if place >= 0 else None
        near = max((each for each in self._near if each <= stamp), default=None)
        if near is not None and (found is None or near > found[0]):
            found = near, self._near[near]
        return (found[0], found[1].copied()) if found is not None else None

    @property
    def last(self) -> int:
        """The time of the last copy [ns]; -1: there is none."""
        return self._stamps[-1] if self._stamps else -1


class Player:
    """Shows one frame of a source at a time.

    Attributes:
        source: The recording.
        frame: The frame that is shown; None before the first.
        drawer: Draws it.
        playing: Whether it goes on by itself.
        backwards: Whether it goes back.
        loop: Whether it begins again at the end.
        rate: Wanted rate: log time over time.
        since: From when on the view remembers [ns]; the recording's start, if it remembers all.
    """

    def __init__(
        self,
        opened: Callable[[], ReplaySource],
        *,
        size: tuple[int, int] | None = None,
        rate: float = 1.0,
        loop: bool = False,
    ) -> None:
        """Open the recording; nothing is shown yet.

        Args:
            opened: Opens it; called again for what `prepare` does.
            size: Columns and rows to draw at [cells]; None: those of the console then.
            rate: Wanted rate.
            loop: Whether it begins again at the end.
        """
        self._opened = opened
        self.source = opened()
        self._size = size
        self.rate, self.loop = rate, loop
        self.playing = self.backwards = False
        self.frame: ReplayFrame | None = None
        self._at = self.source.start - 1
        self.since = self.source.start
        self.drawer = FrameDrawer(size)
        self._memory = Memory()
        self._builder: _Builder | None = None
        self._ticked: float | None = None
        self._target = float(self.source.start)
        self._passed: deque[tuple[float, int]] = deque()

    @property
    def position(self) -> int:
        """The time of the frame that is shown [ns]."""
        return self.frame.stamp if self.frame is not None else self.source.start

    @property
    def complete(self) -> bool:
        """Whether the view remembers all frames since the start."""
        return self.since <= self.source.start

    def resize(self, size: tuple[int, int] | None) -> None:
        """Draw at another size from now on."""
        if size != self._size:
            self._size, self._memory, self._builder = size, Memory(), None
            self.drawer = FrameDrawer(size)
            self._at, at = -1, self.position
            self.seek(at)

    def seek(self, stamp: int, *, whole: bool = False) -> Cells | None:
        """Show the newest frame at or before a time.

        Args:
            stamp: The time [ns].
            whole: Whether to take all frames before it, however long that takes.

        Returns:
            The cells; None if there is nothing to show.
        """
        stamp = min(max(stamp, self.source.start), self.source.end)
        self._target = float(stamp)
        self._passed.clear()
        target = self.source.frame_before(stamp)
        if target is None:
            return None
        known = self._memory.before(target - 1)
        ahead = self._at < target and self.complete
        if ahead and (known is None or known[0] <= self._at):
            pass  # it is on the way
        elif known is not None and (whole or target - known[0] <= 2 * EVERY_NS):
            self._at, self.drawer = known
            self.since = self.source.start
        else:
            self._at = (
                self.source.start - 1 if whole else max(target - WARM_NS, self.source.start) - 1
            )
            self.drawer = FrameDrawer(self._size)
            self.since = self._at + 1
        if not whole and self.complete and target - self._at > 2 * EVERY_NS:
            self._at, self.drawer = target - WARM_NS, FrameDrawer(self._size)
            self.since = self._at + 1
        self._take(target, math.inf, near=True)
        return self.drawer.cells

    def step(self, count: int) -> Cells | None:
        """Show the next frame, or the one before (-1)."""
        self.playing = False
        find = self.source.frame_after if count > 0 else self.source.frame_before
        found = find(self.position if count > 0 else self.position - 1)
        return self.seek(found) if found is not None else None

    def tick(self, now: float, clock: Callable[[], float] | None = None, busy: float = 0.0) -> bool:
        """Go on by the time since the last call; returns whether another frame is shown.

        Args:
            now: The time [s].
            clock: The clock of `busy`.
            busy: Longest time that it may take [s]; without a clock any.
        """
        elapsed = 0.0 if self._ticked is None else now - self._ticked
        self._ticked = now
        if not self.playing:
            return False
        way = -1.0 if self.backwards else 1.0
        self._target += way * elapsed * self.rate * _SECOND
        before = self.position
        if self.backwards:
            self._back()
        else:
            until = math.inf if clock is None else clock() + busy
            self._take(int(min(self._target, self.source.end)), until, clock=clock)
            # What is out of reach is not made up for later.
            self._target = min(self._target, self._at + self.rate * _SECOND)
            if self._at >= self.source.end:
                self._end()
        self._passed.append((now, self.position))
        while now - self._passed[0][0] > _MEASURED_S:
            self._passed.popleft()
        return self.position != before

    @property
    def reached(self) -> float:
        """The rate of the last second; the wanted one, if that is not known."""
        if len(self._passed) < 2:
            return self.rate
        (begin, first), (end, last) = self._passed[0], self._passed[-1]
        return abs(last - first) / _SECOND / (end - begin) if end - begin > 0.5 else self.rate

    def faster(self, steps: int) -> None:
        """Take the next rate, or the one before (-1)."""
        place = min(range(len(_RATES)), key=lambda number: abs(_RATES[number] - self.rate))
        self.rate = _RATES[min(len(_RATES) - 1, max(0, place + steps))]
        self._passed.clear()

    def turn(self) -> None:
        """Go the other way."""
        self.backwards = not self.backwards
        self._target = float(self.position)
        self._passed.clear()

    def prepare(self, clock: Callable[[], float], busy: float) -> bool:
        """Take frames of the whole recording for any later jump; returns whether more are left.

        Args:
            clock: A clock [s].
            busy: Longest time that it may take [s].
        """
        if self._builder is None:
            self._builder = _Builder(self._opened, self._memory, self._size)
        more = self._builder.go_on(clock, clock() + busy)
        if not self.complete and self._memory.last >= self.position - EVERY_NS:
            target, self._target = self._target, 0.0
            self.seek(self.position, whole=True)
            self._target = target
        return more

    def survey(self) -> Overview:
        """What happened in the whole recording; any thread may call it."""
        source = self._opened()
        try:
            return source.overview()
        finally:
            source.close()

    def close(self) -> None:
        """Close the files."""
        self.source.close()
        if self._builder is not None:
            self._builder.close()

    def _take(
        self,
        until: int,
        end: float,
        *,
        clock: Callable[[], float] | None = None,
        near: bool = False,
    ) -> None:
        """Take the frames up to a time, and draw the last one."""
        waiting: ReplayFrame | None = None
        for count, frame in enumerate(self.source.frames(self._at, until)):
            if waiting is not None:
                self._feed(waiting)
                if near and count % _NEAR == 0 and self.complete:
                    self._memory.keep_near(waiting.stamp, self.drawer)
            waiting = frame
            if clock is not None and clock() >= end:
                until = frame.stamp
                break
        if waiting is not None:
            self.drawer.draw(waiting)
            self.frame = waiting
            self._note(waiting.stamp)
        self._at = max(self._at, until)

    def _feed(self, frame: ReplayFrame) -> None:
        self.drawer.feed(frame)
        self._note(frame.stamp)

    def _note(self, stamp: int) -> None:
        if self.complete:
            self._memory.keep(stamp, self.drawer)

    def _back(self) -> None:
        target = self.source.frame_before(int(max(self._target, self.source.start)))
        if target is not None and target < self.position:
            wanted, passed = self._target, list(self._passed)
            self.seek(target)
            self._target = wanted
            self._passed.extend(passed)
        if self._target <= self.source.start:
            self._end()

    def _end(self) -> None:
        """Begin again, or stop."""
        if not self.loop:
            self.playing = False
            return
        self.seek(self.source.end if self.backwards else self.source.start)


class _Builder:
    """Takes all frames of a recording from the start, a few at a time, for copies of the view."""

    def __init__(
        self, opened: Callable[[], ReplaySource], memory: Memory, size: tuple[int, int] | None
    ) -> None:
        self._source = opened()
        self._memory = memory
        known = memory.before(self._source.end)
        self._at, self._drawer = known or (self._source.start - 1, FrameDrawer(size))
        self._frames: Iterator[ReplayFrame] = self._source.frames(self._at, self._source.end)

    def go_on(self, clock: Callable[[], float], end: float) -> bool:
        while clock() < end:
            frame = next(self._frames, None)
            if frame is None:
                return False
            self._drawer.feed(frame)
            self._memory.keep(frame.stamp, self._drawer)
        return True

    def close(self) -> None:
        self._source.close()
