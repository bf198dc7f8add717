"""Every error of studies.

StudyError
├── AnswersError                  a file of answers that cannot be written, or does not fit
├── QuestionnaireError (ValueError)  a questionnaire's file with mistakes, all of them listed
└── DataError (ValueError)    data that a metric or a statistic cannot take
"""

from __future__ import annotations

from collections.abc import Sequence

from hub.errors import HubError


class StudyError(HubError):
    """A study, its files or its data cannot be used."""


class DataError(StudyError, ValueError):
    """Data that a metric or a statistic cannot take: a wrong shape, range or unit."""


class QuestionnaireError(StudyError, ValueError):
    """A questionnaire's file with mistakes, all of them listed."""

    def __init__(self, name: str, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        lines = [f"{name}: {problem}" for problem in problems]
        super().__init__("\n".join(lines))


class AnswersError(StudyError):
    """A file of answers that cannot be written, or does not fit its questionnaire."""
