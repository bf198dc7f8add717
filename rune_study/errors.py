"""Every error of studies.

StudyError
├── StudyFileError (ValueError)   a study's file with mistakes, all of them listed
├── ChangedStudyError (ValueError)  a study that is not the one with which a session began
├── TrialError                    a part of a trial that does not run
├── AnswersError                  a file of answers that cannot be written, or does not fit
├── QuestionnaireError (ValueError)  a questionnaire's file with mistakes, all of them listed
└── DataError (ValueError)    data that a metric or a statistic cannot take
"""

from __future__ import annotations

from collections.abc import Sequence

from hub.errors import HubError, at_lines


class StudyError(HubError):
    """A study, its files or its data cannot be used."""


class StudyFileError(StudyError, ValueError):
    """A study's file with mistakes.

    Attributes:
        problems: One sentence for each mistake.
    """

    def __init__(self, path: str, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        super().__init__(at_lines(path, problems))


class ChangedStudyError(StudyError, ValueError):
    """A study that is not the one with which a session began."""


class TrialError(StudyError):
    """A part of a trial does not run: a robot says nothing, or nothing records."""


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
