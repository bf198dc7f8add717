"""Ends the console on the system's signals, and with a terminal that blocks."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import threading
from collections.abc import Callable

_LEAVE_S = 3.0
"""Longest time of an orderly end before the process is ended by force [s]."""


def run_on_termination(loop: asyncio.AbstractEventLoop, work: Callable[[], None]) -> None:
    """Run some work on SIGTERM and SIGHUP.

    Without signal handlers (Windows, tests in a thread) the process ends at once, and the robot
    stops by itself.
    """
    for name in ("SIGTERM", "SIGHUP"):
        with contextlib.suppress(AttributeError, NotImplementedError, ValueError, RuntimeError):
            loop.add_signal_handler(getattr(signal, name), work)


def force_end_later() -> None:
    """End the process by force after a time limit.

    Textual waits until the terminal has read all output; a blocked terminal never does.
    """
    last_resort = threading.Timer(_LEAVE_S, os._exit, (1,))
    last_resort.daemon = True
    last_resort.start()
