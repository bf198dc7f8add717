"""How other threads have something done in the thread that runs Textual."""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
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
