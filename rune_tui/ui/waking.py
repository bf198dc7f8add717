"""How other threads and the system have something done in the thread that runs Textual."""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import signal
from collections.abc import Callable


def waker(loop: asyncio.AbstractEventLoop, work: Callable[[], None]) -> Callable[[], None]:
    """What other threads call to have some work done at once.

    Args:
        loop: The running loop; what is called after its end has no effect.
        work: What to do, in the context of this call, in which Textual finds its app.
    """
    context = contextvars.copy_context()

    def wake() -> None:
        with contextlib.suppress(RuntimeError):
            loop.call_soon_threadsafe(work, context=context)

    return wake


def at_the_systems_end(loop: asyncio.AbstractEventLoop, work: Callable[[], None]) -> None:
    """Have some work done when the system asks the process to end, instead of its end.

    Where signals cannot be handled (Windows, tests in a thread), they end the process as they
    always do, and the robot stops by itself.
    """
    for name in ("SIGTERM", "SIGHUP"):
        with contextlib.suppress(AttributeError, NotImplementedError, ValueError, RuntimeError):
            loop.add_signal_handler(getattr(signal, name), work)
