"""How much of a recording is unpacked: a small file can say that it is endless.

| what | at most |
| --- | --- |
| one part of a file, unpacked | 64 MB |
| all parts together, unpacked | 256 times the size of the files, or 1 GB if that is more |
| records in one part | 1 million |
| records in all parts together | one for each 16 bytes of the files, or 1 million if that is more |

The option `--unpack SIZE` puts one size in place of the first two. In place of the others it allows
a record for each 32 bytes of that size. Each part counts once, however often it is read.
"""

from __future__ import annotations

from typing import Final

from hub.errors import RecordingError

_PART: Final = 64_000_000
_LEAST: Final = 1_000_000_000
_TIMES: Final = 256
"""LZ4 packs no better than this."""
_RECORDS: Final = 1_000_000
_PACKED_RECORD: Final = 16
_RECORD: Final = 32


class BudgetError(RecordingError):
    """A recording unpacks to more than is read."""

    def __init__(self, what: str) -> None:
        super().__init__(f"{what}; if you trust the file, read more of it with --unpack 10GB")


class ReadBudget:
    """What may be unpacked of the files of one recording.

    Attributes:
        part: Most bytes of one part, unpacked.
        records: Most records in one part.
        total: Most bytes of all parts, unpacked.
    """

    def __init__(self, size: int, unpacked: int = 0) -> None:
        """Begin.

        Args:
            size: Length of the files [bytes].
            unpacked: Most bytes that are unpacked; 0: by the size.
        """
        self.part = unpacked or _PART
        self.total = unpacked or max(_LEAST, _TIMES * size)
        self.records = unpacked // _RECORD or _RECORDS
        self._left = self.total
        self._records_left = unpacked // _RECORD or max(_RECORDS, size // _PACKED_RECORD)
        self._known: set[object] = set()

    def of_part(self, *name: object) -> PartBudget:
        """The budget for one part; a name that was there before is the same part."""
        return PartBudget(self, name)

    def unpack(self, part: object, size: int) -> None:
        """Take a part before it is unpacked.

        Args:
            part: Names it.
            size: Its length, unpacked [bytes].

        Raises:
            BudgetError: It is more than is read.
        """
        if size > self.part:
            text = f"a part of it unpacks to {size} bytes, more than {self.part}, and is left out"
            raise BudgetError(text)
        if ("bytes", part) in self._known:
            return
        if size > self._left:
            text = f"it unpacks to more than {self.total} bytes, and the rest is left out"
            raise BudgetError(text)
        self._left -= size
        self._known.add(("bytes", part))

    def count(self, part: object, records: int) -> None:
        """Take the records of a part.

        Raises:
            BudgetError: They are more than are read.
        """
        if records > self.records:
            text = f"a part of it has more than {self.records} records, and is left out"
            raise BudgetError(text)
        if ("records", part) in self._known:
            return
        if records > self._records_left:
            text = "it has more records than its size explains, and the rest is left out"
            raise BudgetError(text)
        self._records_left -= records
        self._known.add(("records", part))


class PartBudget:
    """What may be unpacked of one part; see `ReadBudget`.

    Attributes:
        records: Most records in it.
    """

    def __init__(self, budget: ReadBudget, name: object) -> None:
        self.records = budget.records
        self._budget = budget
        self._name = name

    def unpack(self, size: int) -> None:
        """Take it before it is unpacked to a length [bytes]; see `ReadBudget.unpack`."""
        self._budget.unpack(self._name, size)

    def count(self, records: int) -> None:
        """Take its records; see `ReadBudget.count`."""
        self._budget.count(self._name, records)
