"""A session step by step: it goes on at the first step that is not done."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rune_study.errors import StudyError
from rune_study.plan.steps import Step
from rune_study.session.journal import BEGIN, DECLINED, DONE, Journal

Result = Mapping[str, Any]
"""What a step says of itself, as JSON has it."""


class LeftError(StudyError):
    """The participant or the experimenter left the session; it can be resumed."""


class DeclinedError(LeftError):
    """The participant does not agree to take part; the session is over."""


def run_steps(
    steps: Sequence[Step], journal: Journal, do: Callable[[Step, int], Result | None]
) -> bool:
    """Do all steps that are not done.

    Args:
        steps: The plan.
        journal: Gets begin and end of each step.
        do: Does a step, given the number of the attempt; None: it has to be done again.

    Returns:
        Whether all steps are done; False: a step was left, or the participant declined.
    """
    for step in steps:
        while step.number not in journal.done():
            attempt = journal.attempts(step.number) + 1
            begin = {"n": step.number, "attempt": attempt, "step": step.name}
            journal.put(BEGIN, **begin, trial=step.trial, code=step.code)
            try:
                result = do(step, attempt)
            except DeclinedError:
                journal.put(DECLINED, n=step.number, attempt=attempt, step=step.name)
                return False
            except LeftError as left:
                journal.put("left", n=step.number, attempt=attempt, why=str(left))
                return False
            if result is None:
                journal.put("failed", n=step.number, attempt=attempt)
            else:
                journal.put(DONE, n=step.number, attempt=attempt, result=dict(result))
    return True
