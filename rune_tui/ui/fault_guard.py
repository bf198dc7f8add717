"""Continues after a fault in one step of many: the next step may be a stop."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator
from typing import Final

from rune_tui.files.user_files import Outcome

_logger = logging.getLogger(__name__)

_NOT_DONE: Final = "something could not be done; the log says why"


class FaultGuard:
    """Logs and reports each kind of fault once."""

    def __init__(self, notify: Callable[[Outcome], None]) -> None:
        """Prepare; `notify` shows the operator a notice."""
        self._notify = notify
        self._failed: set[object] = set()

    @contextlib.contextmanager
    def __call__(self, what: object) -> Iterator[None]:
        """Continue after a fault in the block.

        Args:
            what: An effect, whose type is the kind of fault, or the name of a step.
        """
        try:
            yield
        except Exception:  # a fault of a plugin or of one robot must not stop the rest
            kind = what if isinstance(what, str) else type(what)
            if kind not in self._failed:
                self._failed.add(kind)
                _logger.exception("%r was not done", what)
                self._notify(Outcome(text=_NOT_DONE, alarm=True))
