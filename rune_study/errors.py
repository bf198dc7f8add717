"""Every error of studies.

StudyError
└── DataError (ValueError)    data that a metric or a statistic cannot take
"""

from __future__ import annotations

from hub.errors import HubError


class StudyError(HubError):
    """A study, its files or its data cannot be used."""


class DataError(StudyError, ValueError):
    """Data that a metric or a statistic cannot take: a wrong shape, range or unit."""
