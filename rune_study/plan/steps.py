"""The plan of a participant: a pure function of the study and the participant's number."""

from __future__ import annotations

import dataclasses
import string
from typing import Any

from hub.values import dataclass
from rune_study.lots import draw, shuffled, spread
from rune_study.plan.orders import BY_LOT, ROWS, Row, Rule, drawn, no_run_above, row_of
from rune_study.plan.study_file import latest
from rune_study.plan.study_spec import MomentsSpec, StudySpec

TRIALS, PRACTICE, BREAK = "trials", "practice", "break"
SECONDARY = "secondary"
TRIAL = "trial"
_SEEDS = 1 << 31


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A step of a session.

    Attributes:
        number: Of the step, from 0.
        kind: `trial`, `practice`, `break`, `secondary`, or the name of a text or questionnaire.
        trial: Number of the trial that it belongs to, from 1; 0: none.
        condition: Index of the trial's condition; -1: none.
        code: The condition's code, A for example; empty: none.
        seconds: Its longest time [s]; 0: any.
        freezes: When the questions of a freeze begin, from the trial's start [s].
        withheld: When control is withheld, from the trial's start [s].
        questions: When the secondary task asks, from the trial's start [s].
        seed: Of the simulation.
        link_seed: Of the link.
    """

    number: int = 0
    kind: str
    trial: int = 0
    condition: int = -1
    code: str = ""
    seconds: float = 0.0
    freezes: tuple[float, ...] = ()
    withheld: tuple[float, ...] = ()
    questions: tuple[float, ...] = ()
    seed: int = 0
    link_seed: int = 0

    @property
    def name(self) -> str:
        """Its name in files and on screens: t3, t3-nasa-tlx, consent."""
        if not self.trial:
            return self.kind
        return f"t{self.trial}" if self.kind == TRIAL else f"t{self.trial}-{self.kind}"


def codes(study: StudySpec) -> tuple[str, ...]:
    """The code of each condition: letters, by lot where the study is blind."""
    letters = string.ascii_uppercase[: len(study.conditions)]
    return tuple(shuffled(letters, study.seed, "codes") if study.design.blind else letters)


def base_row(study: StudySpec) -> tuple[Row, int]:
    """The conditions of an order by lot, and in how many blocks they come."""
    one = tuple(range(len(study.conditions)))
    trials = study.design.trials
    return (one, trials) if study.design.order == "blocks" else (one * trials, 1)


def rules(study: StudySpec) -> dict[str, Rule]:
    """What an order by lot keeps, by the words of the study's file."""
    kept = {
        f"apart {name}": no_run_above(1, lambda index, name=name: study.levels[index].get(name))  # type: ignore[misc]
        for name in study.design.apart
    }
    longest = study.design.longest_run
    if longest:
        kept[f"longest_run {longest}"] = no_run_above(longest, lambda index: index)
    return kept


def order_of(study: StudySpec, participant: int) -> Row:
    """The conditions of a participant, trial by trial.

    Raises:
        StudyError: No order keeps the rules.
    """
    if study.design.order in BY_LOT:
        items, blocks = base_row(study)
        return drawn(items, blocks, list(rules(study).values()), study.seed, "order", participant)
    rows = ROWS[study.design.order](len(study.conditions))
    return row_of(rows, participant - 1, study.seed) * study.design.trials


def plan(study: StudySpec, participant: int, replaces: int = 0) -> tuple[Step, ...]:
    """Every step of a participant's session.

    Args:
        study: The study.
        participant: Number of the participant, from 1.
        replaces: The participant whose order this one takes over; 0: none.

    Raises:
        StudyError: No order keeps the rules.
    """
    steps: list[Step] = []
    for kind in study.session.steps:
        if kind == TRIALS:
            order = order_of(study, replaces or participant)
            for trial, condition in enumerate(order, 1):
                steps += _around_trial(study, participant, trial, condition)
        else:
            seconds = {PRACTICE: study.practice.most_s if study.practice else 0.0}
            seconds[BREAK] = study.session.break_s
            seconds[SECONDARY] = study.task.alone_s if study.task else 0.0
            seed = _seed(study, "simulation", participant, kind)
            alone = (
                _questions(study, seconds[SECONDARY], participant, "alone", len(steps))
                if kind == SECONDARY
                else ()
            )
            given = seconds.get(kind, 0.0)
            steps.append(Step(kind=kind, seconds=given, seed=seed, questions=alone))
    return tuple(dataclasses.replace(step, number=number) for number, step in enumerate(steps))


def _around_trial(study: StudySpec, participant: int, trial: int, condition: int) -> list[Step]:
    of_trial: dict[str, Any]
    of_trial = {"trial": trial, "condition": condition, "code": codes(study)[condition]}
    spec = study.conditions[condition]
    same = {"trial": (participant, trial), "condition": (condition,), "study": ()}
    main = Step(
        kind=TRIAL,
        seconds=study.trial.seconds,
        freezes=_moments(study, study.freeze, "freeze", participant, trial),
        withheld=_moments(study, study.withhold, "withhold", participant, trial),
        questions=_questions(study, study.trial.seconds, participant, trial),
        seed=_seed(study, "simulation", participant, trial),
        link_seed=_seed(study, "link", *same[spec.link_seed]),
        **of_trial,
    )
    before, after = (
        [Step(kind=kind, **of_trial) for kind in kinds]
        for kinds in (study.trial.before, study.trial.after)
    )
    return [*before, main, *after]


def _seed(study: StudySpec, *words: object) -> int:
    return int(draw(study.seed, *words) * _SEEDS)


def _moments(study: StudySpec, spec: MomentsSpec | None, *words: object) -> tuple[float, ...]:
    if spec is None:
        return ()
    last = latest(spec, study.trial)
    moments = spread(spec.count, spec.not_before_s, last, spec.apart_s, study.seed, *words)
    return tuple(round(moment, 3) for moment in moments)


def _questions(study: StudySpec, seconds: float, *words: object) -> tuple[float, ...]:
    """When the secondary task asks: pauses by lot until the end [s]."""
    if study.task is None:
        return ()
    least, most = study.task.every_s
    moments: list[float] = []
    at = 0.0
    while True:
        at += least + (most - least) * draw(study.seed, "secondary", *words, len(moments))
        if at >= seconds:
            return tuple(moments)
        moments.append(round(at, 3))
