"""Logs the sentences for people at panels: panels that make them alternate flood no log."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Final

from hub.bucket import Bucket

AT_ONCE: Final = 10
"""Sentences that are logged at once."""
_PER_S = 1.0 / 60.0
"""Sentences that are logged in the long run [1/s]."""


class SentenceLog:
    """Logs a few sentences, then one a minute."""

    def __init__(self, logger: logging.Logger, clock: Callable[[], float]) -> None:
        """Log with this logger; `clock` is monotonic [s]."""
        self._logger, self._clock = logger, clock
        self._bucket = Bucket(_PER_S, AT_ONCE)

    def note(self, text: str) -> None:
        """Log a sentence, unless there were too many; empty: nothing."""
        if text and self._bucket.take(1.0, self._clock()):
            self._logger.warning("%s", text)
