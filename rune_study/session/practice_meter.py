"""Metrics of the last part of practice, from recordings that are still being written."""

from __future__ import annotations

import threading
import time
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Final

from hub.errors import HubError
from hub.values import dataclass
from rune_study.metrics.registry import measure
from rune_study.metrics.trial import MeasureSpec
from rune_study.metrics.trial_time import trial_time
from rune_study.trial_data.measured import Surroundings, trial_data
from rune_study.trial_data.recorded import recorded_robots
from rune_study.trial_data.truth import truth_of

AGAIN_S: Final = 3.0
"""Least time between the end of a computation and the begin of the next [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PracticeFiles:
    """What is measured.

    Attributes:
        consoles: Folder of the console's recording.
        hubs: Recordings of the robots' hubs.
        arena: Name or path of the arena; empty: it is not known.
        effectiveness: Which progress is task effectiveness.
        measures: Numbers that the study fixed.
    """

    consoles: Path
    hubs: Sequence[Path]
    arena: str
    effectiveness: str
    measures: MeasureSpec


class PracticeMeter:
    """Computes metrics in a thread of its own, so that the trial goes on meanwhile.

    Attributes:
        values: Those that were known at the end of the last computation, by name.
    """

    def __init__(self, files: PracticeFiles, names: Collection[str]) -> None:
        """Prepare to compute these metrics; without names nothing is computed."""
        self.values: Mapping[str, float] = {}
        self._files = files
        self._names = names
        self._thread: threading.Thread | None = None
        self._next = 0.0

    def look(self, begin: float, end: float, pauses: Sequence[tuple[float, float]]) -> None:
        """Begin to compute if it is time to.

        Args:
            begin: Begin of the part of practice on the monotonic clock [s].
            end: Its end, about now [s].
            pauses: Begin and end of each pause [s].
        """
        now = time.monotonic()
        busy = self._thread is not None and self._thread.is_alive()
        if not self._names or busy or now < self._next:
            return
        self._thread = threading.Thread(
            target=self._compute, args=(begin, end, tuple(pauses)), daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Wait for the end of a computation."""
        if self._thread is not None:
            self._thread.join()

    def _compute(self, begin: float, end: float, pauses: tuple[tuple[float, float], ...]) -> None:
        try:
            self.values = measured(self._files, self._names, begin, end, pauses)
        except HubError:  # nothing is on the disk yet, or a file is cut just there
            self.values = {}
        finally:
            self._next = time.monotonic() + AGAIN_S


def measured(
    files: PracticeFiles,
    names: Collection[str],
    begin: float,
    end: float,
    pauses: Sequence[tuple[float, float]],
) -> dict[str, float]:
    """The known ones of some metrics of a part of practice.

    Raises:
        HubError: A recording or the arena cannot be read.
    """
    inside = [(max(first, begin) - begin, last - begin) for first, last in pauses if last > begin]
    around = Surroundings(
        time=trial_time(0.0, end - begin, inside),
        truth=truth_of(files.arena) if files.arena else None,
        effectiveness=files.effectiveness,
    )
    consoles = sorted(files.consoles.glob("*.mcap"))
    with recorded_robots(consoles, files.hubs, begin, end) as robots:
        data = trial_data({role: log for role, (log, _) in robots.items()}, around)
    found = measure(data, files.measures, names)
    return {name: each.value for name, each in found.items() if each.known}
