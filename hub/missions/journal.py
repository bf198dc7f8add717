"""The journal's form: one line for each record, with its length and a checksum; pure.

A line is `CRC LENGTH JSON`: the CRC-32 of the JSON as eight hexadecimal digits, its length in
bytes, and a JSON object without line breaks. A reader finds the next line after any damage. What a
crash has left of the last line counts as not written.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Callable
from typing import Any

from hub.errors import MissionFileError
from hub.values import dataclass

MAX_RECORD_BYTES = 65_536
_HEAD = re.compile(rb"([0-9a-f]{8}) ([0-9]{1,6}) ")
_HEAD_BYTES = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """The result of reading a journal.

    Attributes:
        count: Number of readable records.
        damaged: Number of damaged parts within the journal.
        end: Bytes up to the end of the last whole line, readable or not.
    """

    count: int
    damaged: int
    end: int


NOTHING = Reading(count=0, damaged=0, end=0)


def encode(record: dict[str, Any]) -> bytes:
    """The line of a record.

    Raises:
        ValueError: It is too long for a reader, or has a number that JSON does not have.
    """
    body = json.dumps(record, ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode()
    if len(body) > MAX_RECORD_BYTES:
        text = f"a record of {len(body)} bytes is longer than {MAX_RECORD_BYTES}"
        raise ValueError(text)
    return b"%08x %d %s\n" % (zlib.crc32(body), len(body), body)


def decode(raw: bytes, take: Callable[[dict[str, Any]], object], most: int) -> Reading:
    """Read a journal record by record, with any damage.

    Args:
        raw: The journal.
        take: Called with each readable record, in order.
        most: Records and damaged stretches that are read.

    Raises:
        MissionFileError: There are more.
    """
    at = end = damaged = count = 0
    while at < len(raw):
        if count + damaged >= most:
            if raw.find(b"\n", at) < 0:
                break
            text = f"has more than {most} records"
            raise MissionFileError(text)
        found = _record(raw, at)
        if found is not None:
            record, at = found
            take(record)
            count += 1
            # The line break itself may be damaged.
            at = end = min(at + 1, len(raw))
            continue
        next_line = raw.find(b"\n", at)
        if next_line < 0:
            break
        damaged += 1
        at = end = next_line + 1
    return Reading(count=count, damaged=damaged, end=end)


def _record(raw: bytes, at: int) -> tuple[dict[str, Any], int] | None:
    """The record that begins here and its end; None: no record begins here."""
    head = _HEAD.match(raw[at : at + _HEAD_BYTES])
    if head is None:
        return None
    begin = at + head.end()
    body = raw[begin : begin + int(head[2])]
    if len(body) != int(head[2]) or len(body) > MAX_RECORD_BYTES:
        return None
    if zlib.crc32(body) != int(head[1], 16):
        return None
    try:
        record = json.loads(body)
    except (ValueError, RecursionError):
        return None
    return (record, begin + len(body)) if isinstance(record, dict) else None
