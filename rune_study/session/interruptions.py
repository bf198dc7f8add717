"""What interrupts a trial: frozen questions, withheld control, and the secondary task."""

from __future__ import annotations

import time
from typing import Any

from rune_study.plan.steps import Step
from rune_study.plan.study_spec import StudySpec
from rune_study.session.freezing import Freezes
from rune_study.session.journal import Journal
from rune_study.session.progress import LeftError
from rune_study.session.schedule import FREEZE, QUESTION, WITHHOLD, Due, Schedule
from rune_study.session.secondary import SecondaryTask
from rune_study.session.stage import Stage


class Interruptions:
    """Begins and ends them; all that happens is in the journal."""

    def __init__(
        self, study: StudySpec, step: Step, attempt: int, journal: Journal, stage: Stage
    ) -> None:
        self._study = study
        self._step = step
        self._journal = journal
        self._stage = stage
        self._freezes = Freezes(study, step, attempt, journal, stage)
        self._task = SecondaryTask(study, step, journal)
        self._withheld_at: float | None = None
        self._will_withhold = False
        if self._task.keys:
            stage.console.order("listen", keys=list(self._task.keys))

    def begin(self, due: Due, schedule: Schedule) -> None:
        """Begin what is due.

        Raises:
            LeftError: The questions of a freeze were left.
        """
        if due.what == FREEZE:
            self._freeze(due, schedule)
        elif due.what == WITHHOLD:
            self._will_withhold = True
            self._withhold_soon()
            self._note("withhold", due)
        elif due.what == QUESTION:
            self._stage.console.order("say", text=self._task.ask(due, time.monotonic()))

    @property
    def withholds(self) -> bool:
        """Whether control is withheld."""
        return self._withheld_at is not None

    def look(self, now: float) -> None:
        """End what is over."""
        spec = self._study.withhold
        self._task.look(now)
        if spec is not None and self._withheld_at is not None:
            low = max(robot.low_for(now) for robot in self._stage.robots)
            waited = now - self._withheld_at
            dropped = min(low, waited) >= spec.still_s
            if dropped or waited >= spec.longest_s:
                self._allow("drop" if dropped else "time", waited=waited, low=low)
                self._stage.console.order("say", text="CONTROL IS YOURS AGAIN")

    def withheld(self) -> None:
        """Take the console's report that it withholds control now."""
        self._will_withhold = False
        self._withheld_at = time.monotonic()
        self._stage.console.order("say", text="CONTROL IS WITHHELD")
        self._note("withheld", None)

    def answer(self, key: str, moment: float) -> None:
        """Take a key that the console reported, pressed at a moment [s]."""
        self._task.end(key, moment)

    def close(self) -> None:
        """End what is open at the end of the trial."""
        self._task.end(None, time.monotonic(), counts=False)

    def pause(self, schedule: Schedule) -> None:
        """Stop clock, simulation and view; an open question of the secondary task is withdrawn.

        Withheld control ends, and tells nothing of the robot's work: robots stand in a pause. One
        that waits for a quiet moment waits for the first after the pause in which inputs were used.
        """
        schedule.pause(time.monotonic())
        if self._withheld_at is not None:
            self._allow("pause", waited=time.monotonic() - self._withheld_at)
        elif self._will_withhold:
            self._stage.console.order("allow")
        self._task.end(None, time.monotonic(), counts=False)
        for robot in self._stage.robots:
            robot.pause(on=True)
        self._stage.console.order("withdraw")
        self._stage.console.wait_for("withdrawn")
        list(self._stage.console.reports())  # of before the pause

    def go_on(self, schedule: Schedule) -> None:
        """Go on after a pause."""
        self._stage.console.order("return")
        self._stage.console.wait_for("returned")
        for robot in self._stage.robots:
            robot.pause(on=False)
        schedule.go_on(time.monotonic())
        if self._will_withhold:
            self._withhold_soon()

    def _withhold_soon(self) -> None:
        self._stage.console.order("withhold", quiet=self._study.metrics.gap_s)

    def _allow(self, why: str, **seconds: float) -> None:
        """End withheld control."""
        self._withheld_at = None
        self._stage.console.order("allow")
        rounded = {name: round(value, 3) for name, value in seconds.items()}
        self._note("allowed", None, why=why, **rounded)

    def _freeze(self, due: Due, schedule: Schedule) -> None:
        time_left = self._step.seconds - schedule.elapsed(time.monotonic())
        self.pause(schedule)
        complete = self._freezes.ask(due.number, time_left)
        self._note("unfrozen", due, complete=complete)
        self.go_on(schedule)
        if not complete:
            why = "the questions of a freeze were left"
            raise LeftError(why)

    def _note(self, what: str, due: Due | None, **data: Any) -> None:  # noqa: ANN401 - JSON
        number = {} if due is None else {"number": due.number}
        self._journal.put(what, n=self._step.number, **number, **data)
