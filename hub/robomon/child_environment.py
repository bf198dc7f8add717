"""The environment of every process that the daemon starts."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping

_FOR_THE_DAEMON_ALONE = ("NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID")
_MARK_NAME = "RUNE_HUB_RUN"
_MARK_VALUE = secrets.token_hex(8)

MARK = f"{_MARK_NAME}={_MARK_VALUE}"
"""The orphan reaper finds by it what modules have started, in any group and session."""


def child_environment(more: Mapping[str, str]) -> dict[str, str]:
    """The daemon's environment, `more` variables, and the mark."""
    own = {k: v for k, v in os.environ.items() if k not in _FOR_THE_DAEMON_ALONE}
    # Unbuffered: a line of the log is needed when the module writes it.
    return {"PYTHONUNBUFFERED": "1", **own, **more, _MARK_NAME: _MARK_VALUE}
