"""Opens the next layout on request, and a layout again after a change of its file."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable

from hub.errors import HubError
from rune_tui.errors import ConsoleError, LayoutError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.layout.watching import CHECK_S, LayoutSource, first_problem

_logger = logging.getLogger(__name__)

_LONGEST_FAULT = 500


class LayoutFollower:
    """Reads layouts in a thread, so that driving continues."""

    def __init__(
        self,
        source: LayoutSource,
        open_it: Callable[[LayoutSpec], Awaitable[None]],
        report: Callable[[str], None],
        say: Callable[[str], None],
    ) -> None:
        """Prepare.

        Args:
            source: The layouts on the command line.
            open_it: Opens a layout; after a fault in it, the old layout stays.
            report: Called with the reason if a layout cannot be opened.
            say: Called with what another layout can show since now.
        """
        self._source = source
        self._open = open_it
        self._report, self._say = report, say
        self._wanted = asyncio.Event()

    def next(self) -> bool:
        """Request the next layout; False if there is none."""
        if self._source.several:
            self._wanted.set()
        return self._source.several

    async def run(self) -> None:
        """Follow until cancelled."""
        while self._source.changes:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._wanted.wait(), CHECK_S)
            look = self._source.next if self._wanted.is_set() else self._source.check
            self._wanted.clear()
            try:
                if news := await asyncio.to_thread(self._source.news):
                    self._say(news)
                found = await asyncio.to_thread(look)
                if isinstance(found, LayoutError):
                    self._report(first_problem(found))
                elif found is not None:
                    await self._open(found)
            except (ConsoleError, HubError) as error:
                self._report(f"The layout stays as it was: {error}"[:_LONGEST_FAULT])
            except Exception as error:  # an extension may fail in any way
                _logger.exception("a layout cannot be opened")
                text = f"The layout stays as it was: {type(error).__name__}: {error}"
                self._report(text[:_LONGEST_FAULT])
