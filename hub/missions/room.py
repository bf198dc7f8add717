"""How much of a journal each kind of record may use; pure.

| record | leaves free |
| --- | --- |
| a changed mark, a name, a note | 1 MiB |
| a new mark, a removal | 64 KiB |
| a sheet, a frame, the begin, the end | nothing: it is never refused |

So changes of marks cannot use the room of new marks, or that of the end of the mission.
"""

from __future__ import annotations

from hub.missions import journal_file
from hub.missions.records import Begun, Ended, FrameKnown, Marked, Record, Removed, SheetBegun

_BYTES_OF_A_RECORD = 256
"""Free bytes for each free record."""


def always_taken(record: Record) -> bool:
    """Whether a record is taken by a full journal too."""
    return isinstance(record, Begun | SheetBegun | FrameKnown | Ended)


def fits(record: Record, size: int, count: int) -> bool:
    """Whether a journal may have this record.

    Args:
        record: The new record.
        size: Of the journal with the record [bytes].
        count: Records of the journal with this one.
    """
    if always_taken(record):
        return True
    new = isinstance(record, Removed) or (isinstance(record, Marked) and record.point.version <= 1)
    free = 64 << 10 if new else 1 << 20
    places = free // _BYTES_OF_A_RECORD
    small = size + free <= journal_file.MAX_BYTES
    return small and count + places <= journal_file.MAX_RECORDS
