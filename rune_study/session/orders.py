"""Orders of the experimenter: a file in the participant's folder, which the session reads."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from hub.errors import MissionFileError
from hub.missions import journal_file
from hub.values import dataclass
from rune_study.errors import StudyError

ORDERS = "orders.log"
BEGIN, PAUSE, END, ABORT, MARK, NOTE = "begin", "pause", "end", "abort", "mark", "note"
KINDS = {
    BEGIN: "begin the trial that waits, or go on after a pause",
    PAUSE: "pause the trial",
    END: "end the trial; it counts",
    ABORT: "leave the session; it goes on later at the step that was left",
    MARK: "mark this moment",
    NOTE: "write a note",
}
"""What the experimenter can order."""
_LONGEST = 500


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """An order.

    Attributes:
        do: One of `KINDS`.
        text: The words of a mark or a note.
        at: When [s since 1970].
    """

    do: str
    text: str
    at: float


class OrderBook:
    """The orders that come from now on; older ones belong to earlier runs of the session."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / ORDERS
        self._size = self._length()
        self._taken = len(self._all())

    def fresh(self) -> list[Order]:
        """The orders since the last call."""
        size = self._length()
        if size == self._size:
            return []
        orders = self._all()
        fresh, self._taken, self._size = orders[self._taken :], len(orders), size
        return fresh

    def _length(self) -> int:
        return self._path.stat().st_size if self._path.exists() else 0

    def _all(self) -> list[Order]:
        found: list[Order] = []

        def take(line: dict[str, Any]) -> None:
            do, text, at = line.get("do"), line.get("text"), line.get("at")
            if do in KINDS and isinstance(text, str) and isinstance(at, float):
                found.append(Order(do=do, text=text[:_LONGEST], at=at))

        if self._path.exists():
            try:
                journal_file.read(self._path, take)
            except MissionFileError as fault:
                raise StudyError(str(fault)) from fault
        return found


def give_order(folder: Path, do: str, text: str = "") -> None:
    """Give an order to the session of a participant's folder.

    Raises:
        StudyError: It cannot be written.
    """
    try:
        file = journal_file.JournalFile(folder / ORDERS)
        try:
            file.append([{"do": do, "text": text[:_LONGEST], "at": time.time()}])
        finally:
            file.close()
    except MissionFileError as fault:
        raise StudyError(str(fault)) from fault
