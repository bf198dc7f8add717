"""How the console ends: because the system asks, and although its terminal takes nothing."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import threading
from collections.abc import Callable

_LEAVE_S = 3.0
"""How long the end may take before the process is ended as it is [s]."""


def at_the_systems_end(loop: asyncio.AbstractEventLoop, work: Callable[[], None]) -> None:
    """Have some work done when the system asks the process to end, instead of its end.

    Where signals cannot be handled (Windows, tests in a thread), they end the process as they
    always do, and the robot stops by itself.
    """
    for name in ("SIGTERM", "SIGHUP"):
        with contextlib.suppress(AttributeError, NotImplementedError, ValueError, RuntimeError):
            loop.add_signal_handler(getattr(signal, name), work)


def end_anyway() -> None:
    """End the process some time from now, should it still be there.

    Textual waits until the terminal has taken everything, which one that has stopped reading
    never does.
    """
    last_resort = threading.Timer(_LEAVE_S, os._exit, (1,))
    last_resort.daemon = True
    last_resort.start()
