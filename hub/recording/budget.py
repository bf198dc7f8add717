"""How much of a recording is unpacked: a small file can say that it is endless.

| what | at most |
| --- | --- |
| one part of a file, unpacked | 64 MB |
| all parts together, unpacked | 256 times the size of the files, or 1 GB if that is more |
| files that are packed as a whole, together, unpacked | the same |
| messages that are packed alone, together, each time all are read | the same |
| records in one part | 1 million |
| records in all parts together | one for each 16 bytes of the files, or 1 million if that is more |

The option `--unpack SIZE` puts one size in place of the bytes. In place of the records it allows
one for each 32 bytes of that size. Each part counts once, however often it is read. Messages count
that unpack to more than 256 times their length.
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


class Allowance:
    """What is left of a bound on several things together."""

    def __init__(self, total: int, fault: str) -> None:
        """Begin.

        Args:
            total: The bound, in bytes or records.
            fault: What is said of more, without its subject.
        """
        self._left = total
        self._fault = fault
        self._known: set[object] = set()

    def take(self, amount: int, of: object = "it") -> None:
        """Take a part of it.

        Args:
            amount: How much, in bytes or records.
            of: What has too much if it is more than is left.

        Raises:
            BudgetError: It is more than is left.
        """
        if amount > self._left:
            text = f"{of} {self._fault}"
            raise BudgetError(text)
        self._left -= amount

    def take_once(self, name: object, amount: int) -> None:
        """The same; a name for which something was taken before takes nothing.

        Raises:
            BudgetError: It is more than is left.
        """
        if name not in self._known:
            self.take(amount)
            self._known.add(name)


class ReadBudget:
    """What may be unpacked of the files of one recording.

    Attributes:
        part: Most bytes of one part, unpacked.
        records: Most records in one part.
        all_parts: Bytes that are left for all parts, unpacked.
        all_records: Records that are left for all parts.
        all_files: Bytes that are left for files that are packed as a whole, unpacked.
    """

    def __init__(self, size: int, unpacked: int = 0) -> None:
        """Begin.

        Args:
            size: Length of the files [bytes].
            unpacked: Most bytes that are unpacked; 0: by the size.
        """
        self.part = unpacked or _PART
        self.records = unpacked // _RECORD or _RECORDS
        self._total = unpacked or max(_LEAST, _TIMES * size)
        self.all_parts = self.of_pass()
        self.all_files = Allowance(self._total, f"unpacks to more than {self._total} bytes")
        self.all_records = Allowance(
            unpacked // _RECORD or max(_RECORDS, size // _PACKED_RECORD),
            "has more records than its size explains, and the rest is left out",
        )

    def of_part(self, *name: object) -> PartBudget:
        """The budget for one part; a name that was there before is the same part."""
        return PartBudget(self, name)

    def of_pass(self) -> Allowance:
        """The bytes that messages packed alone may have, unpacked, while all are read once."""
        fault = f"unpacks to more than {self._total} bytes, and the rest is left out"
        return Allowance(self._total, fault)


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
        """Take it before it is unpacked to a length [bytes].

        Raises:
            BudgetError: It is more than is read.
        """
        most = self._budget.part
        if size > most:
            text = f"a part of it unpacks to {size} bytes, more than {most}, and is left out"
            raise BudgetError(text)
        self._budget.all_parts.take_once(self._name, size)

    def count(self, records: int) -> None:
        """Take its records.

        Raises:
            BudgetError: They are more than are read.
        """
        if records > self.records:
            text = f"a part of it has more than {self.records} records, and is left out"
            raise BudgetError(text)
        self._budget.all_records.take_once(self._name, records)
