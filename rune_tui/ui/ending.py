"""Ends the console on the system's signals, and with a terminal that blocks."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import threading
from collections.abc import Callable

LEAVE_S = 3.0
"""Longest time until the terminal has read all output, before an end by force [s]."""


def run_on_termination(loop: asyncio.AbstractEventLoop, work: Callable[[], None]) -> None:
    """Run some work on SIGTERM and SIGHUP.

    Without signal handlers (Windows, tests in a thread) the process ends at once, and the robot
    stops by itself.
    """
    for name in ("SIGTERM", "SIGHUP"):
        with contextlib.suppress(AttributeError, NotImplementedError, ValueError, RuntimeError):
            loop.add_signal_handler(getattr(signal, name), work)


def force_end_later() -> Callable[[], None]:
    """End the process by force after a time limit; returns what cancels that.

    Textual waits until the terminal has read all output; a blocked terminal never does.
    """
    last_resort = threading.Timer(LEAVE_S, os._exit, (1,))
    last_resort.daemon = True
    last_resort.start()
    return last_resort.cancel
