"""The environment of every process that the daemon starts."""

from __future__ import annotations

import functools
import os
import secrets
from collections.abc import Mapping

_FOR_THE_DAEMON_ALONE = ("NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID")
_MARK_NAME = "RUNE_HUB_RUN"


@functools.cache
def _mark_value() -> str:
    return secrets.token_hex(8)


def mark() -> str:
    """The mark of this daemon's modules and their children, in any process group and session.

    The orphan reaper finds them by it. A process has one; it draws it when it first asks.
    """
    return f"{_MARK_NAME}={_mark_value()}"


def child_environment(more: Mapping[str, str]) -> dict[str, str]:
    """The daemon's environment, `more` variables, and the mark."""
    own = {k: v for k, v in os.environ.items() if k not in _FOR_THE_DAEMON_ALONE}
    # Unbuffered: log lines must not wait in the module.
    return {"PYTHONUNBUFFERED": "1", **own, **more, _MARK_NAME: _mark_value()}
