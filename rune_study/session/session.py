"""A participant's session in this terminal: every step of the plan, from the first not done."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

from hub import files
from rune_study.errors import StudyError
from rune_study.plan.conditions import limit_words
from rune_study.plan.folder import questionnaire_path, text_path
from rune_study.plan.practice import practice_of
from rune_study.plan.real_robots import RealRobots, real_problems
from rune_study.plan.steps import BREAK, PRACTICE, SECONDARY, TRIAL, Step, plan
from rune_study.plan.study_spec import ConditionSpec, StudySpec
from rune_study.questionnaires.asking import ask, is_refused
from rune_study.questionnaires.questionnaire import read as read_questionnaire
from rune_study.session.freezing import ANSWERS
from rune_study.session.journal import Journal
from rune_study.session.markers import lsl_markers, no_markers
from rune_study.session.orders import ABORT, BEGIN, OrderBook
from rune_study.session.progress import DeclinedError, LeftError, Result, run_steps
from rune_study.session.reading import forget_keys, read
from rune_study.session.secondary import do_alone
from rune_study.session.stage import stage
from rune_study.session.study_log import study_log
from rune_study.session.trial import Trial
from rune_study.session.warnings import PRIVATE

_LARGEST_TEXT = 1_000_000
"""Longest page of a study [bytes]."""
_BREAK = "# A break\n\nPlease rest."
_SECONDARY = "# Questions\n\nAnswer each question that appears with one of the keys {keys}."
_PRACTICE = "# Practice\n\nDrive the robot until you know how. Quit the console when you are ready."
_NOT_PASSED = (
    "# Practice\n\nThe practice ended before its aim was reached. Please tell the experimenter."
)
_DECLINED = "# Thank you\n\nYou do not take part, and the session is over. Thank you for your time."
_AT_START = "\n\nThe robot has to stand at its start. Nothing moves it there by itself."
_ALL_AT_START = "\n\nAll robots have to stand at their starts. Nothing moves them there by itself."
_AGAIN = "\n\nThe last attempt does not count: {why}."
_TRIAL = "# Trial {number} of {count}\n\nIt takes up to {time}."


class Session:
    """Does the steps of a participant."""

    def __init__(
        self, study: StudySpec, journal: Journal, participant: int, real: RealRobots
    ) -> None:
        """Prepare.

        Args:
            study: The study.
            journal: The participant's.
            participant: The number.
            real: Real robots that take the place of those of all conditions.

        Raises:
            StudyError: Markers are wanted and cannot be sent, or the robots do not fit.
        """
        problems = real_problems(study, real.hubs)
        if problems:
            raise StudyError("; ".join(problems))
        self._study = study
        self._journal = journal
        self._folder = journal.path.parent
        self._code = self._folder.name.replace("sub-", "p")
        self._real = real
        self._again = ""
        self._steps = plan(study, participant, journal.replaces)
        self._book = OrderBook(self._folder)
        self._mark: Callable[[str], None] = no_markers
        if study.markers.lsl:
            self._mark = lsl_markers(f"{study.digest[:8]}-{self._code}")

    def run(self) -> bool:
        """Do all steps that are not done; returns whether all are.

        Raises:
            HubError: A hub or a file cannot be used.
            ConsoleError: A simulated robot did not start.
        """
        complete = run_steps(self._steps, self._journal, self._do)
        if self._journal.declined:
            with contextlib.suppress(LeftError):
                read(_DECLINED)
        return complete

    def _do(self, step: Step, attempt: int) -> Result | None:
        if step.kind in (TRIAL, PRACTICE):
            spec = self._condition(step)
            limits = {} if self._study.design.blind else limit_words(spec)
            given = self._journal, self._study.digest, self._code, step, attempt, limits
            with study_log(*given):
                return self._try(step, attempt, spec)
        self._mark(f"step {step.name}")
        if step.kind == BREAK:
            text = text_path(self._study, BREAK)
            read(_BREAK if text is None else _text(text), seconds=step.seconds)
            return {}
        if step.kind == SECONDARY:
            text = text_path(self._study, SECONDARY)
            read(_secondary_page(self._study) if text is None else _text(text))
            return do_alone(self._study, step, self._journal)
        return self._page_and_questions(step)

    def _page_and_questions(self, step: Step) -> Result:
        page = text_path(self._study, step.kind)
        if page is not None:
            read(_text(page))
        path = questionnaire_path(self._study, step.kind)
        if path is None:
            if page is None:
                text = f"there is no step {step.kind!r}; `rune study check` says what is missing"
                raise StudyError(text)
            return {}
        questionnaire = read_questionnaire(path)
        file = self._folder / (PRIVATE if questionnaire.private else ANSWERS)
        forget_keys()
        if not ask(questionnaire, file, step.name, f"{self._study.seed} {self._code} {step.name}"):
            if is_refused(questionnaire, file, step.name):
                why = "the participant declined"
                raise DeclinedError(why)
            why = f"{step.name} is not complete"
            raise LeftError(why)
        return {"questionnaire": questionnaire.name}

    def _condition(self, step: Step) -> ConditionSpec:
        """The condition of a trial or of practice."""
        if step.kind != PRACTICE:
            return self._study.conditions[step.condition]
        first = next((each for each in self._steps if each.kind == TRIAL), step)
        return practice_of(self._study, self._study.conditions[first.condition])

    def _try(self, step: Step, attempt: int, spec: ConditionSpec) -> Result | None:
        real = self._real.of(spec)
        self._wait_for_begin(step, real)
        with stage(
            self._study,
            spec,
            step,
            folder=self._folder,
            operator=self._code,
            attempt=attempt,
            real=real,
        ) as running:
            given = (self._study, step, attempt, self._journal, running, self._book, self._mark)
            trial = Trial(*given)
            result = trial.run()
        self._again = trial.failure
        if result is not None and misses_aim(result):
            with contextlib.suppress(LeftError):  # what was done stays done
                read(_NOT_PASSED)
        return result

    def _wait_for_begin(self, step: Step, real: RealRobots) -> None:
        count = sum(each.kind == TRIAL for each in self._steps)
        text = _TRIAL.format(number=step.trial, count=count, time=length_in_words(step.seconds))
        by_experimenter = step.kind == TRIAL and self._study.trial.begins == "experimenter"
        page = _PRACTICE if step.kind == PRACTICE else text
        if self._again:
            page += _AGAIN.format(why=self._again)
        if real.hubs:
            page += _AT_START if len(real.hubs) == 1 else _ALL_AT_START
        read(
            page,
            ended=self._may_begin if by_experimenter else None,
        )

    def _may_begin(self) -> bool:
        orders = self._book.fresh()
        for order in orders:
            self._journal.put("order", do=order.do, text=order.text, given=order.at)
        if any(order.do == ABORT for order in orders):
            why = "the experimenter left the session"
            raise LeftError(why)
        return any(order.do == BEGIN for order in orders)


def misses_aim(result: Result) -> bool:
    """Whether a participant quit practice before its criterion was met."""
    return result.get("passed") is False and result["ended"] == "operator"


def length_in_words(seconds: float) -> str:
    """A length of time [s] as people say it: in seconds below two minutes."""
    return f"{seconds / 60.0:.0f} minutes" if seconds >= 120.0 else f"{seconds:.0f} seconds"


def _secondary_page(study: StudySpec) -> str:
    keys = " ".join(study.task.keys).upper() if study.task is not None else ""
    return _SECONDARY.format(keys=keys)


def _text(path: Path) -> str:
    try:
        return files.read_regular(path, _LARGEST_TEXT).decode("utf-8")
    except (OSError, ValueError) as fault:
        text = f"{path} cannot be read: {fault}"
        raise StudyError(text) from fault
