"""Every error of studies."""

from __future__ import annotations

from hub.errors import HubError


class StudyError(HubError):
    """A study, its files or its data cannot be used."""
