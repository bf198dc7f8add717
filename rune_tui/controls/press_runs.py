"""Which reports of a key are presses, where releases are not reported; for keys that do not drive.

A press and a repeat are the same report there. A key that is held repeats after 0.2 to 1 s, then at
least eight times a second. The states of a key:

| state | event | it is | next |
| --- | --- | --- | --- |
| UP | a report | a press | PRESSED |
| PRESSED | a report | a repeat, or a second press | SECOND |
| PRESSED | no report for `FIRST_QUIET_S` | | UP |
| SECOND | no report for `PROOF_S` or `SLOW_PROOF_S` | it was a second press | UP |
| PRESSED, SECOND | a report from a pause of the console | it does not count | HELD |
| SECOND | a report | both were repeats | HELD |
| HELD | a report | a repeat | HELD |
| HELD | no report for `QUIET_S` | | UP |

So a second press may come as soon as a finger can, and counts a moment later. A finger that goes up
right after the first repeat looks the same as two presses.

A press from a pause does not count, so the operator presses again: that is a second press too.
"""

from __future__ import annotations

from collections.abc import Iterator

from hub.values import dataclass
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.release_guard import FIRST_QUIET_S, QUIET_S, ReleaseGuard

_HELD = 3
"""Number of reports from which only the first is a press."""


@dataclass(slots=True)
class _Run:
    """Reports of one key that may belong to one press.

    Attributes:
        last: Time of the last report [s].
        reports: Number of reports, at most `_HELD`.
        fine: Whether Shift was down at the last one.
        stale: Whether one of them may be from a pause: then only a second press has a release.
    """

    last: float
    reports: int = 1
    fine: bool = False
    stale: bool = False

    @property
    def second(self) -> bool:
        """Whether the last report may be a second press."""
        return self.reports == 2

    @property
    def released(self) -> bool:
        """Whether its end is a release of a press that counts."""
        return self.second or not self.stale


class PressRuns:
    """The keys that do not drive; the clock is passed in."""

    def __init__(self, guard: ReleaseGuard) -> None:
        """Take what knows how long a key must be quiet."""
        self._guard = guard
        self._runs: dict[str, _Run] = {}

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that may be down, in the order of their presses."""
        return tuple(self._runs)

    @property
    def awaits_proof(self) -> bool:
        """Whether silence can show a second press."""
        return any(run.second for run in self._runs.values())

    def report(self, key: str, read: float, *, fine: bool, stale: bool) -> ControlEvent:
        """Take a report of a key; returns its press or repeat.

        Args:
            key: Its name.
            read: The time at which it was read [s].
            fine: Whether Shift is down.
            stale: Whether it may have been typed while the console paused.
        """
        run = self._runs.get(key)
        repeat = run is not None
        if run is None:
            self._runs[key] = _Run(last=read, fine=fine, stale=stale)
        else:
            run.last, run.fine, run.stale = read, fine, run.stale or stale
            run.reports = _HELD if stale else min(_HELD, run.reports + 1)
        return ControlEvent(
            name=key,
            pressed=True,
            repeat=repeat,
            fine=fine,
            timed=True,
            must_release_first=stale,
            stale=stale,
        )

    def expire(self, now: float) -> Iterator[ControlEvent]:
        """Second presses that are proven now, and releases that are due."""
        for key, run in tuple(self._runs.items()):
            if not self._guard.quiet(run.last, self._needed(run), now):
                continue
            del self._runs[key]
            if run.second:
                yield ControlEvent(name=key, pressed=True, fine=run.fine, timed=True, second=True)
            if run.released:
                yield ControlEvent(name=key, pressed=False)

    def release_all(self) -> Iterator[ControlEvent]:
        """Release all keys, without a second press."""
        keys = [key for key, run in self._runs.items() if not run.stale]
        self._runs.clear()
        for key in keys:
            yield ControlEvent(name=key, pressed=False)

    def _needed(self, run: _Run) -> float:
        """Time without a report that ends a run [s]."""
        if run.second:
            return self._guard.proof_s
        return FIRST_QUIET_S if run.reports == 1 else QUIET_S
