"""Follows the layouts of a running console: the next one that is asked for, and saved changes."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable

from rune_tui.errors import LayoutError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.layout.watching import LOOK_S, LayoutSource, first_problem

_logger = logging.getLogger(__name__)

_LONGEST_COMPLAINT = 500


class LayoutFollower:
    """Reads layouts in a thread, so that driving goes on."""

    def __init__(
        self,
        source: LayoutSource,
        read: Callable[[LayoutSpec], Awaitable[None]],
        complain: Callable[[str], None],
    ) -> None:
        """Prepare.

        Args:
            source: What is shown and what may come instead of it.
            read: Called with each layout that was read.
            complain: Called with why one was not.
        """
        self._source = source
        self._read = read
        self._complain = complain
        self._wanted = asyncio.Event()

    def next(self) -> bool:
        """Have the next layout read; False if there is none."""
        if self._source.several:
            self._wanted.set()
        return self._source.several

    async def run(self) -> None:
        """Follow until it is cancelled."""
        while self._source.changes:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._wanted.wait(), LOOK_S)
            look = self._source.next if self._wanted.is_set() else self._source.look
            self._wanted.clear()
            try:
                found = await asyncio.to_thread(look)
            except Exception as error:  # an extension's code may fail in any way
                _logger.exception("a layout cannot be read")
                self._complain(kept(error))
                continue
            if isinstance(found, LayoutError):
                self._complain(first_problem(found))
            elif found is not None:
                await self._read(found)


def kept(error: Exception) -> str:
    """That another layout could not be taken, and why."""
    return f"The layout stays as it was: {type(error).__name__}: {error}"[:_LONGEST_COMPLAINT]
