"""Runs work of other threads in Textual's thread."""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
from collections.abc import Callable
from typing import TypeVarTuple

Given = TypeVarTuple("Given")


def waker(
    loop: asyncio.AbstractEventLoop, work: Callable[[*Given], None]
) -> Callable[[*Given], None]:
    """A function for other threads that runs some work in the loop's thread at once.

    Args:
        loop: The running loop; calls after its end have no effect.
        work: The work; it runs in the context of this call, where Textual finds its app.
    """
    context = contextvars.copy_context()

    def wake(*given: *Given) -> None:
        with contextlib.suppress(RuntimeError):
            loop.call_soon_threadsafe(work, *given, context=context)

    return wake
