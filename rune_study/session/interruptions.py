"""What interrupts a trial: frozen questions, withheld control, and the secondary task."""

from __future__ import annotations

import time
from typing import Any

from rune_study.lots import shuffled
from rune_study.plan.steps import Step
from rune_study.plan.study_spec import StudySpec
from rune_study.session.freezing import Freezes
from rune_study.session.journal import Journal
from rune_study.session.progress import LeftError
from rune_study.session.schedule import FREEZE, QUESTION, WITHHOLD, Due, Schedule
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
        self._question: tuple[Due, float] | None = None
        self._withheld_at: float | None = None
        if study.task is not None:
            stage.console.order("listen", keys=list(study.task.keys))

    def begin(self, due: Due, schedule: Schedule) -> None:
        """Begin what is due.

        Raises:
            LeftError: The questions of a freeze were left.
        """
        if due.what == FREEZE:
            self._freeze(due, schedule)
        elif due.what == WITHHOLD:
            self._withheld_at = time.monotonic()
            self._stage.console.order("withhold")
            self._stage.console.order("say", text="CONTROL IS WITHHELD")
            self._note("withheld", due)
        elif due.what == QUESTION and self._study.task is not None:
            self._end_question(None, time.monotonic())
            self._question = due, time.monotonic()
            self._stage.console.order("say", text=self._asked(due))

    def look(self, now: float) -> None:
        """End what is over."""
        task, spec = self._study.task, self._study.withhold
        asked = self._question
        if task is not None and asked is not None and now - asked[1] > task.longest_s:
            self._end_question(None, now)
        if spec is not None and self._withheld_at is not None:
            still = max(robot.still_for(now) for robot in self._stage.robots)
            waited = now - self._withheld_at
            if min(still, waited) >= spec.still_s or waited >= spec.longest_s:
                self._withheld_at = None
                self._stage.console.order("allow")
                self._stage.console.order("say", text="CONTROL IS YOURS AGAIN")
                self._note("allowed", None, waited=round(waited, 3), still=round(still, 3))

    def answer(self, key: str, moment: float) -> None:
        """Take a key that the console reported, pressed at a moment [s]."""
        self._end_question(key, moment)

    def pause(self, schedule: Schedule) -> None:
        """Stop clock, simulation and view."""
        schedule.pause(time.monotonic())
        for robot in self._stage.robots:
            robot.pause(on=True)
        self._stage.console.order("withdraw")
        self._stage.console.wait_for("withdrawn")

    def go_on(self, schedule: Schedule) -> None:
        """Go on after a pause."""
        self._stage.console.order("return")
        self._stage.console.wait_for("returned")
        for robot in self._stage.robots:
            robot.pause(on=False)
        schedule.go_on(time.monotonic())

    def _freeze(self, due: Due, schedule: Schedule) -> None:
        time_left = self._step.seconds - schedule.elapsed(time.monotonic())
        self.pause(schedule)
        complete = self._freezes.ask(due.number, time_left)
        self._note("unfrozen", due, complete=complete)
        self.go_on(schedule)
        if not complete:
            why = "the questions of a freeze were left"
            raise LeftError(why)

    def _asked(self, due: Due) -> str:
        task = self._study.task
        return task.ask[self._which(due)] if task is not None else ""

    def _which(self, due: Due) -> int:
        """Index of the text that a question shows."""
        task = self._study.task
        order = range(len(task.ask)) if task is not None else range(1)
        return shuffled(order, self._study.seed, self._step.seed, "ask", due.number)[0]

    def _end_question(self, key: str | None, moment: float) -> None:
        task = self._study.task
        if task is None or self._question is None:
            return
        due, asked = self._question
        self._question = None
        right = task.right[self._which(due)]
        seconds = None if key is None else round(moment - asked, 4)
        given = {"key": key, "right": right, "correct": key == right, "seconds": seconds}
        self._note("secondary", due, asked=asked, text=self._asked(due), **given)

    def _note(self, what: str, due: Due | None, **data: Any) -> None:  # noqa: ANN401 - JSON
        number = {} if due is None else {"number": due.number}
        self._journal.put(what, n=self._step.number, **number, **data)
