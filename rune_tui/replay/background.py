"""Reads a recording in the background: all of it, and what the shown frame needs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

from hub.values import dataclass
from rune_tui.replay.drawing import FrameDrawer
from rune_tui.replay.source import ReplayFrame, ReplaySource
from rune_tui.replay.view_copies import ViewCopies

WARM_NS: Final = 3_000_000_000
"""Log time of the frames that are taken where there is no copy [ns]."""
THIN_NS: Final = 200_000_000
"""Log time between frames that fill a memory, and of those between drawn ones at high rates [ns].

Lines of plots and trails have no gaps then.
"""
_FAR_NS: Final = 60_000_000_000
"""Log time from a copy, from which all frames are taken in a little time [ns]."""


class FrameReader:
    """Takes the frames of a part of a recording into a drawer, a few at a time.

    Attributes:
        at: The last time whose frames are taken [ns].
        drawer: Remembers these frames.
        apart: Least log time between two frames that are taken [ns]; 0: all are taken.
    """

    def __init__(
        self, source: ReplaySource, at: int, drawer: FrameDrawer, *, apart: int = 0
    ) -> None:
        """Prepare to take the frames later than `at`; `source` serves one reader at a time."""
        self.at, self.drawer, self.apart = at, drawer, apart
        self._source = source
        self._frames: Iterator[ReplayFrame] | None = None
        self._until = at

    def go_on(
        self,
        until: int,
        clock: Callable[[], float],
        end: float,
        copies: ViewCopies | None = None,
    ) -> bool:
        """Take frames; returns whether all up to a time are taken.

        Args:
            until: The time [ns].
            clock: A clock [s].
            end: When to stop [s].
            copies: Gets copies of the drawer.
        """
        while self.at < until:
            if self._frames is None:
                self._until = until
                self._frames = self._source.frames(self.at, until, self.apart)
            frame = next(self._frames, None)
            if frame is None:
                self._frames, self.at = None, self._until
                continue
            self.drawer.feed(frame)
            self.at = frame.stamp
            if copies is not None:
                copies.keep(frame.stamp, self.drawer)
            if clock() >= end:
                return False
        return True

    def pause(self) -> None:
        """Let another reader use the source."""
        self._frames = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FilledView:
    """A view whose memory is filled.

    Attributes:
        at: The last time whose frames are taken [ns].
        drawer: Has the view.
        exact: Whether all frames before are taken.
    """

    at: int
    drawer: FrameDrawer
    exact: bool


class BackgroundReader:
    """Reads all of a recording for later jumps, and a part of it for the frame that is shown."""

    def __init__(self, opened: Callable[[], ReplaySource]) -> None:
        """Prepare; `opened` opens the recording when it is needed."""
        self._opened = opened
        self._source: ReplaySource | None = None
        self._size: tuple[int, int] | None = None
        self._copies = ViewCopies(0)
        self._whole: FrameReader | None = None
        self._filler: FrameReader | None = None

    @property
    def at(self) -> int:
        """Up to where all frames are read [ns]; 0: not begun."""
        return self._whole.at if self._whole is not None else 0

    def begin(self, copies: ViewCopies, size: tuple[int, int] | None) -> None:
        """Begin again.

        Args:
            copies: Gets copies of the view.
            size: Columns and rows to draw at [cells]; None: those of the console then.
        """
        self._copies, self._size = copies, size
        self._whole = self._filler = None

    def read_on(self, clock: Callable[[], float], end: float) -> bool:
        """Read on from the begin of the recording; returns whether more is left.

        Args:
            clock: A clock [s].
            end: When to stop [s].
        """
        source = self._spare
        if self._whole is None:
            start = source.start - 1
            known = self._copies.before(self._copies.end_from(start))
            self._whole = FrameReader(source, *(known or (start, FrameDrawer(self._size))))
        return not self._whole.go_on(source.end, clock, end, self._copies)

    def fill(
        self, position: int, memory_s: float, clock: Callable[[], float], end: float
    ) -> FilledView | None:
        """Fill a view for the frame at a time; None: it needs more time.

        Args:
            position: The time [ns].
            memory_s: How long ago what the view shows may have been [s].
            clock: A clock [s].
            end: When to stop [s].
        """
        if self._filler is None:
            self._filler = self._new_filler(position, round(1e9 * memory_s))
        filler = self._filler
        exact = filler.apart == 0
        until = position - (1 if exact else WARM_NS)
        if not filler.go_on(until, clock, end, self._copies if exact else None):
            return None
        self.drop_fill()
        if exact:
            self._whole = None  # it goes on from the copies that this made
        return FilledView(at=filler.at, drawer=filler.drawer, exact=exact)

    def drop_fill(self) -> None:
        """Drop what was read for a frame."""
        if self._filler is not None:
            self._filler.pause()
            self._filler = None

    def close(self) -> None:
        """Close the files."""
        if self._source is not None:
            self._source.close()

    @property
    def _spare(self) -> ReplaySource:
        """The recording, opened for this alone."""
        if self._source is None:
            self._source = self._opened()
        return self._source

    def _new_filler(self, position: int, memory: int) -> FrameReader:
        """Takes all frames from a time that is not too far, or some of the view's memory."""
        source = self._spare
        if self._whole is not None:
            self._whole.pause()
        start = source.start - 1, FrameDrawer(self._size)
        at, drawer = self._copies.before(position - 1) or start
        if position - at <= _FAR_NS:
            return FrameReader(source, at, drawer)
        if position - memory > at:
            at, drawer = min(position - memory, position - WARM_NS), FrameDrawer(self._size)
        return FrameReader(source, at, drawer, apart=THIN_NS)
