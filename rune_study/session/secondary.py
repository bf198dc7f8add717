"""The secondary task: a text that waits for a key, beside the robot or alone."""

from __future__ import annotations

import time
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.events import Key
from textual.widgets import Static

from rune_study.lots import shuffled
from rune_study.plan.steps import Step
from rune_study.plan.study_spec import SecondarySpec, StudySpec
from rune_study.session.journal import Journal
from rune_study.session.progress import LeftError, Result
from rune_study.session.reading import forget_keys
from rune_study.session.schedule import Due, Schedule
from rune_tui.controls.keyboard import name_of_key

ANSWERED = "secondary"
"""Kind of the journal's record of a question, written when it is over."""
_LOOK_S = 0.02


class SecondaryTask:
    """One question at a time; each one is in the journal when it is over."""

    def __init__(self, study: StudySpec, step: Step, journal: Journal) -> None:
        """Prepare; without a secondary task nothing is asked."""
        self._study = study
        self._step = step
        self._journal = journal
        self._open: tuple[Due, float] | None = None

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of answers; none: there is no task."""
        return self._study.task.keys if self._study.task is not None else ()

    def ask(self, due: Due, now: float) -> str:
        """Begin a question [s, monotonic clock]; returns its text. An open one is missed."""
        self.end(None, now)
        self._open = due, now
        return self._text(due) if self._study.task is not None else ""

    def look(self, now: float) -> bool:
        """Whether a question was open until now, and its time is over."""
        task = self._study.task
        over = task is not None and self._open is not None and now - self._open[1] > task.longest_s
        if over:
            self.end(None, now)
        return over

    def end(self, key: str | None, moment: float, *, counts: bool = True) -> bool:
        """End the open question.

        Args:
            key: The key of the answer; None: there is none.
            moment: When it was pressed [s, monotonic clock].
            counts: Whether it could be answered: not if the trial was paused or ended before.

        Returns:
            Whether one was open.
        """
        task, opened = self._study.task, self._open
        if task is None or opened is None:
            return False
        self._open = None
        due, asked = opened
        right = task.right[self._which(task, due)]
        self._journal.put(
            ANSWERED,
            n=self._step.number,
            number=due.number,
            asked=asked,
            text=self._text(due),
            key=key,
            right=right,
            correct=key == right,
            seconds=None if key is None else round(moment - asked, 4),
            counts=counts,
        )
        return True

    def _text(self, due: Due) -> str:
        task = self._study.task
        return task.ask[self._which(task, due)] if task is not None else ""

    def _which(self, task: SecondarySpec, due: Due) -> int:
        """Index of the text that a question shows."""
        order = range(len(task.ask))
        return shuffled(order, self._study.seed, self._step.seed, "ask", due.number)[0]


class AloneScreen(App[bool]):
    """The secondary task without a robot; ends with whether its time is over."""

    CSS = """
    Screen { align: center middle; }
    #text { width: auto; height: auto; text-style: bold; }
    """
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar = [("ctrl+c", "leave", "Leave")]

    def __init__(self, task: SecondaryTask, step: Step) -> None:
        """Begin when the screen is there."""
        super().__init__()
        self._secondary = task
        self._step = step
        self._schedule = Schedule(step, time.monotonic())

    def compose(self) -> ComposeResult:
        """Make the only widget."""
        yield Static(id="text", markup=False)

    def on_mount(self) -> None:
        """Let the time run."""
        self._schedule = Schedule(self._step, time.monotonic())
        self.set_interval(_LOOK_S, self._look)

    def on_key(self, event: Key) -> None:
        """Take an answer."""
        name = name_of_key(event.key, event.character)
        if name in self._secondary.keys:
            event.stop()
            event.prevent_default()
            if self._secondary.end(name, time.monotonic()):
                self._show("")

    def action_leave(self) -> None:
        """Leave the session."""
        self._secondary.end(None, time.monotonic(), counts=False)
        self.exit(result=False)

    def _look(self) -> None:
        now = time.monotonic()
        if self._schedule.elapsed(now) >= self._step.seconds:
            self._secondary.end(None, now, counts=False)
            self.exit(result=True)
            return
        if self._secondary.look(now):
            self._show("")
        for due in self._schedule.due(now):
            self._show(self._secondary.ask(due, now))

    def _show(self, text: str) -> None:
        self.query_one("#text", Static).update(text)


def do_alone(study: StudySpec, step: Step, journal: Journal) -> Result:
    """Let the person do the secondary task without a robot.

    Raises:
        LeftError: Ctrl-C was pressed.
    """
    forget_keys()
    begun = time.monotonic()
    if not AloneScreen(SecondaryTask(study, step, journal), step).run():
        why = "left with Ctrl-C"
        raise LeftError(why)
    return {"begun": begun, "seconds": step.seconds}
