"""A scripted operator who sits at a real session: reads pages, answers, and drives with keys.

The journal tells which step runs. The operator knows nothing else of the session.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from rune_study.errors import StudyError
from rune_study.plan.folder import participant_folder, questionnaire_path, text_path
from rune_study.plan.steps import BREAK, PRACTICE, SECONDARY, TRIAL, Step, plan
from rune_study.plan.study_spec import StudySpec
from rune_study.questionnaires.answers import read_answers
from rune_study.questionnaires.questionnaire import Questionnaire
from rune_study.questionnaires.questionnaire import read as read_questionnaire
from rune_study.session.freezing import ANSWERS
from rune_study.session.journal import BEGIN, DONE, JOURNAL, Record, read_journal
from rune_study.session.warnings import PRIVATE
from rune_study.simulate.operator_model import OperatorModel
from rune_study.simulate.script import Service, TrueEpisode, script, true_episode
from rune_study.simulate.study_terminal import ARROW_LEFT, ARROW_UP, StudyTerminal
from rune_study.simulate.typed_answers import ENTER, typed_answer

DRIVING_KEYS: Final = (("w", "a"), (ARROW_UP, ARROW_LEFT))
"""Keys that drive and turn each robot in the layouts that come with Rune."""
_LOOK_S: Final = 0.02
_READY_S: Final = 0.3
_AGAIN_S: Final = 2.0
"""A key that had no effect is typed again after this time [s]."""
_START_S: Final = 90.0
"""Longest time from a key to what it begins [s]."""
_TURN_AFTER_S: Final = 0.3
_WAY_OUT: Final = "q"


class TypingOperator:
    """Plays one session.

    Attributes:
        episodes: What was done to robots.
        answers: Number of answers that were given.
        wrong: What the session wrote otherwise than it was typed, in words.
    """

    def __init__(
        self, study: StudySpec, participant: int, terminal: StudyTerminal, model: OperatorModel
    ) -> None:
        """Prepare.

        Args:
            study: The study.
            participant: The number.
            terminal: On which the session runs.
            model: Draws episodes and pauses.
        """
        self.episodes: list[TrueEpisode] = []
        self.answers = 0
        self.wrong: list[str] = []
        self._study = study
        self._participant = participant
        self._terminal = terminal
        self._model = model
        self._folder = participant_folder(study.folder, participant)
        self._steps = {step.number: step for step in plan(study, participant)}
        self._random = np.random.default_rng(participant)

    def play(self) -> bool:
        """Play the session to its end; returns whether it is complete.

        Raises:
            StudyError: It does not do what it should.
        """
        handled: tuple[int, int] | None = None
        while self._terminal.exit_code is None:
            begun = next((each for each in reversed(self._records()) if each.what == BEGIN), None)
            now = None if begun is None else (int(begun.data["n"]), int(begun.data["attempt"]))
            if now is not None and now != handled:
                handled = now
                self._do(self._steps[now[0]], now[1])
            time.sleep(_LOOK_S)
        return {int(each.data["n"]) for each in self._seen(DONE)} == set(self._steps)

    def _do(self, step: Step, attempt: int) -> None:
        if step.kind in (TRIAL, PRACTICE):
            self._read_page()
            self._drive(step, attempt)
        elif step.kind == BREAK:
            self._read_page(step.seconds)
        elif step.kind == SECONDARY:
            self._read_page()
        else:
            if text_path(self._study, step.kind) is not None:
                self._read_page()
            path = questionnaire_path(self._study, step.kind)
            if path is not None:
                self._answer(read_questionnaire(path), step)

    def _read_page(self, seconds: float = 0.0) -> None:
        """Wait for a page, and press Enter until it closes."""
        self._wait(lambda: self._terminal.showing, "no page opens")
        page = self._terminal.screens
        self._type_until(
            ENTER,
            lambda: not self._terminal.showing or self._terminal.screens != page,
            "a page does not close",
            seconds,
        )

    def _answer(self, questionnaire: Questionnaire, step: Step) -> None:
        file = self._folder / (PRIVATE if questionnaire.private else ANSWERS)
        code = self._folder.name.replace("sub-", "p")
        given = self._given(file, questionnaire, step)
        self._wait(lambda: self._terminal.showing, "no questionnaire opens")
        time.sleep(_READY_S)
        if questionnaire.instructions and not given:
            self._terminal.type(ENTER)
            time.sleep(_READY_S)
        for item in questionnaire.order(f"{self._study.seed} {code} {step.name}"):
            if item.id in given:
                continue
            answer, keys = typed_answer(item, self._random)

            def is_answered(name: str = item.id) -> bool:
                return name in self._given(file, questionnaire, step)

            self._type_until(keys, is_answered, f"{item.id} of {questionnaire.name} stays open")
            written = self._given(file, questionnaire, step)[item.id]
            self.answers += 1
            if written != answer:
                self.wrong.append(f"{step.name} {item.id}: typed {answer!r}, written {written!r}")

    def _given(self, file: Path, questionnaire: Questionnaire, step: Step) -> dict[str, object]:
        if not file.exists():
            return {}
        own = questionnaire.name, step.name
        return {
            each.item: each.value
            for each in read_answers(file)
            if (each.questionnaire, each.occasion) == own
        }

    def _drive(self, step: Step, attempt: int) -> None:
        def of_this(what: str) -> Record | None:
            found = [each for each in self._seen(what) if each.data.get("n") == step.number]
            return found[attempt - 1] if len(found) >= attempt else None

        self._wait(
            lambda: of_this("trial-begin") is not None or of_this("failed") is not None,
            "the trial does not begin",
        )
        begin = of_this("trial-begin")
        if begin is None:
            return
        zero = float(begin.data["moment_s"])
        robots = self._study.conditions[step.condition].robots if step.trial else 1
        for each in script(self._model, step, self._study.metrics.gap_s, robots):
            while time.monotonic() < zero + each.begin:
                if of_this("trial-end") is not None:
                    return
                time.sleep(_LOOK_S)
            own = {"participant": self._participant, "trial": step.trial, "attempt": attempt}
            done = self._hold(zero, each)
            if step.trial:
                self.episodes.append(true_episode(own, done))
        if not step.trial and self._study.practice and not self._study.practice.criterion:
            self._terminal.type(_WAY_OUT)

    def _hold(self, zero: float, service: Service) -> Service:
        """Hold keys until an episode's end; returns it as it was."""
        forward, turn = DRIVING_KEYS[service.robot]
        began = time.monotonic() - zero
        self._terminal.press(forward)
        time.sleep(_TURN_AFTER_S)
        self._terminal.press(turn)
        time.sleep(max(0.0, zero + service.end - time.monotonic()))
        self._terminal.release(turn)
        ended = time.monotonic() - zero
        self._terminal.release(forward)
        return Service(robot=service.robot, begin=began, end=ended, until=ended)

    def _type_until(
        self, keys: str, done: Callable[[], bool], why: str, seconds: float = 0.0
    ) -> None:
        """Type keys again and again until they have an effect."""
        end = time.monotonic() + _START_S + seconds
        while not done():
            time.sleep(_READY_S)
            self._terminal.type(keys)
            again = time.monotonic() + _AGAIN_S
            while time.monotonic() < again and not done():
                time.sleep(_LOOK_S)
            self._check(end, why)

    def _wait(self, condition: Callable[[], bool], why: str) -> None:
        end = time.monotonic() + _START_S
        while not condition():
            self._check(end, why)
            time.sleep(_LOOK_S)

    def _check(self, end: float, why: str) -> None:
        if time.monotonic() > end or self._terminal.exit_code is not None:
            text = f"participant {self._participant}: {why}; {self._folder} has the journal"
            raise StudyError(text)

    def _records(self) -> list[Record]:
        path = self._folder / JOURNAL
        return read_journal(path) if path.exists() else []

    def _seen(self, what: str) -> list[Record]:
        return [each for each in self._records() if each.what == what]
