"""Goes on when one thing of many fails: what comes after it may be a stop."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator
from typing import Final

from rune_tui.files.user_files import Outcome

_logger = logging.getLogger(__name__)

_NOT_DONE: Final = "something could not be done; the log says why"


class Sparing:
    """Logs and tells each kind of fault once."""

    def __init__(self, tell: Callable[[Outcome], None]) -> None:
        """Nothing has failed yet.

        Args:
            tell: Tells the operator.
        """
        self._tell = tell
        self._failed: set[object] = set()

    @contextlib.contextmanager
    def __call__(self, what: object) -> Iterator[None]:
        """Go on if what is done in the block fails.

        Args:
            what: An effect, of which each type is a kind, or the name of a step.
        """
        try:
            yield
        except Exception:  # of a widget of somebody else, or of one robot of several
            kind = what if isinstance(what, str) else type(what)
            if kind not in self._failed:
                self._failed.add(kind)
                _logger.exception("%r was not done", what)
                self._tell(Outcome(text=_NOT_DONE, alarm=True))
