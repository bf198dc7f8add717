"""Plays a recording: where it is, how fast it goes, and which frame is shown; pure.

A frame is drawn from what the view remembers of the frames before. So the player keeps copies of
the view, and goes to a time from the last copy before it.

| before a time | what is shown of it |
| --- | --- |
| there is a copy near | all: `Knowledge.ALL` |
| there is none | the frames of the last `WARM_NS`: `Knowledge.SECONDS` |
| that, and `prepare` had a little time | some frames of the view's `memory_s`: `Knowledge.SOME` |
| that, and `prepare` has read the recording up to there | all |
"""

from __future__ import annotations

import enum
import math
from collections import deque
from collections.abc import Callable, Iterator
from itertools import chain
from typing import Final

from hub.recording.holes import beyond_hole
from rune_tui.compositor.cells import Cells
from rune_tui.replay.background import THIN_NS, WARM_NS, BackgroundReader
from rune_tui.replay.drawing import FrameDrawer
from rune_tui.replay.source import Overview, ReplayFrame, ReplaySource
from rune_tui.replay.view_copies import EVERY_NS, ViewCopies

SLOWEST: Final = 0.1
FASTEST: Final = 100.0
_RATES: Final = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
_NEAR: Final = 15
"""Frames between two copies on the way back."""
_REACH_NS: Final = 12_000_000_000
"""Longest log time that a jump takes all frames of before it draws [ns]."""
_MEASURED_S: Final = 1.0
_SECOND: Final = 1_000_000_000


class Knowledge(enum.Enum):
    """What the view remembers of the frames before the one that is shown.

    Attributes:
        SECONDS: Those of the last seconds.
        SOME: Some of all that visualizers can show.
        ALL: All: the picture is that of then.
    """

    SECONDS = 0
    SOME = 1
    ALL = 2


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
        knows: What the view remembers of the frames before.
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
        self.knows = Knowledge.ALL
        self.drawer = FrameDrawer(size)
        self._background = BackgroundReader(opened)
        self._forget()
        self._thin = False
        self._ticked: float | None = None
        self._target = float(self.source.start)
        self._passed: deque[tuple[float, int]] = deque()

    @property
    def position(self) -> int:
        """The time of the frame that is shown [ns]."""
        return self.frame.stamp if self.frame is not None else self.source.start

    @property
    def ready(self) -> float:
        """How much of the recording before the shown frame is read, 0 to 1."""
        whole = self.position - self.source.start
        read = self._background.at - self.source.start
        return min(1.0, max(0.0, read / whole)) if whole else 1.0

    def resize(self, size: tuple[int, int] | None) -> None:
        """Draw at another size from now on."""
        if size != self._size:
            self._size = size
            self._forget()
            self.drawer = FrameDrawer(size)
            self._at, at = -1, self.position
            self.seek(at)

    def _forget(self) -> None:
        """Forget all copies of the view."""
        self._copies = ViewCopies(self.source.end - self.source.start)
        self._background.begin(self._copies, self._size)

    def seek(self, stamp: int, *, whole: bool = False) -> Cells | None:
        """Show the newest frame at or before a time.

        Args:
            stamp: The time [ns].
            whole: Whether to take all frames before it, however long that takes.

        Returns:
            The cells; None if there is nothing to show.
        """
        source = self.source
        stamp = min(max(stamp, source.start), source.end)
        self._target = float(stamp)
        self._passed.clear()
        self._thin = False
        self._background.drop_fill()
        target = source.frame_before(stamp)
        if target is None:
            return None
        known = self._copies.before(target - 1)
        on_the_way = self.knows is Knowledge.ALL and self._at < target
        if on_the_way and (known is None or known[0] <= self._at) and self._near(self._at, target):
            pass
        elif known is not None and (whole or self._near(known[0], target)):
            self._begin(*known, Knowledge.ALL)
        elif not (on_the_way and whole):
            begin = source.start - 1 if whole else max(target - WARM_NS, source.start) - 1
            knows = Knowledge.ALL if begin < source.start else Knowledge.SECONDS
            self._begin(begin, FrameDrawer(self._size), knows)
        self._take(target, math.inf, near=True)
        return self.drawer.cells

    def _near(self, begin: int, target: int) -> bool:
        """Whether a jump may take all frames from one time to another."""
        return target - begin <= max(2 * EVERY_NS, min(self._copies.every, _REACH_NS) + _SECOND)

    def _begin(self, at: int, drawer: FrameDrawer, knows: Knowledge) -> None:
        self._at, self.drawer, self.knows = at, drawer, knows

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
        stamp = beyond_hole(self.source.holes, int(self._target), backwards=self.backwards)
        self._target = float(stamp)
        before = self.position
        if self.backwards:
            self._back()
        else:
            until = math.inf if clock is None else clock() + busy
            ended = self._take(int(min(self._target, self.source.end)), until, clock=clock)
            self._thin = self._thin or not ended
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
        self._thin = False
        self._passed.clear()

    def turn(self) -> None:
        """Go the other way."""
        self.backwards = not self.backwards
        self._target = float(self.position)
        self._passed.clear()

    def prepare(self, clock: Callable[[], float], busy: float) -> bool:
        """Take frames that the shown frame and later jumps need; returns whether more are left.

        Args:
            clock: A clock [s].
            busy: Longest time that it may take [s].
        """
        end = clock() + busy
        if self.knows is not Knowledge.ALL and not (self.playing and self._thin):
            known = self._copies.before(self.position - 1)
            if known is not None and self._near(known[0], self.position):
                self._again(*known, Knowledge.ALL)
            elif self.knows is Knowledge.SECONDS:
                filled = self._background.fill(self.position, self.drawer.memory_s, clock, end)
                if filled is None:
                    return True
                knows = Knowledge.ALL if filled.exact else Knowledge.SOME
                self._again(filled.at, filled.drawer, knows)
        return self._background.read_on(clock, end)

    def _again(self, at: int, drawer: FrameDrawer, knows: Knowledge) -> None:
        """Draw the shown frame again with other memories."""
        position = self.position
        self._thin = False
        self._background.drop_fill()
        self._begin(at, drawer, knows)
        self._take(position, math.inf)

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
        self._background.close()

    def _take(
        self,
        until: int,
        end: float,
        *,
        clock: Callable[[], float] | None = None,
        near: bool = False,
    ) -> bool:
        """Take the frames up to a time, and draw the last one; returns whether all were taken."""
        waiting: ReplayFrame | None = None
        ended = True
        for count, frame in enumerate(self._frames(until)):
            if waiting is not None:
                self._feed(waiting)
                if near and count % _NEAR == 0 and self.knows is Knowledge.ALL:
                    self._copies.keep_near(waiting.stamp, self.drawer)
            waiting = frame
            if clock is not None and clock() >= end:
                until, ended = frame.stamp, False
                break
        if waiting is not None:
            self.drawer.draw(waiting)
            self.frame = waiting
            self._note(waiting.stamp)
        self._at = max(self._at, until)
        return ended

    def _frames(self, until: int) -> Iterator[ReplayFrame]:
        """The frames up to a time; only some of them at a rate that the machine cannot keep."""
        last = until - THIN_NS
        if not self._thin or last <= self._at + THIN_NS:
            return self.source.frames(self._at, until)
        if self.knows is Knowledge.ALL:
            self.knows = Knowledge.SOME
        return chain(self.source.frames(self._at, last, THIN_NS), self.source.frames(last, until))

    def _feed(self, frame: ReplayFrame) -> None:
        self.drawer.feed(frame)
        self._note(frame.stamp)

    def _note(self, stamp: int) -> None:
        if self.knows is Knowledge.ALL:
            self._copies.keep(stamp, self.drawer)

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
