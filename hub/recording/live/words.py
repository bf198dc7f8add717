"""Spans of time, sizes and rates as people write them: "2h", "10 min", "8 GiB", "5/s"; pure."""

from __future__ import annotations

import re
from collections.abc import Mapping

from hub.toml_reader import Reader, RefusedError, Within, shorten

_AMOUNT = re.compile(r"\s*(\d{1,12}(?:\.\d{1,6})?)\s*([A-Za-z]*)\s*", re.ASCII)
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86_400.0}
_BYTES = {
    "B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12,
    "KiB": 2**10, "MiB": 2**20, "GiB": 2**30, "TiB": 2**40,
}  # fmt: skip
LONGEST_S = 366 * 86_400.0
LARGEST = 10**15
LEAST_FILE = 10**6
"""Smallest size that files of a recording may be limited to [bytes]."""


def seconds_of(value: object) -> float:
    """The span of time of "90", "90 s", "10 min", "2h" or "1 d" [s].

    Raises:
        RefusedError: It is none, or longer than a year.
    """
    return _amount(value, _SECONDS, "s", LONGEST_S, "a span of time such as '10 min' or '2h'")


def bytes_of(value: object) -> int:
    """The size of "500 MB" or "8 GiB" [bytes].

    Raises:
        RefusedError: It is none, or larger than a petabyte.
    """
    return round(_amount(value, _BYTES, "B", LARGEST, "a size such as '500 MB' or '8 GiB'"))


def file_bytes_of(value: object) -> int:
    """A size that has room for a recording [bytes].

    Raises:
        RefusedError: It is none, less than a megabyte, or larger than a petabyte.
    """
    size = bytes_of(value)
    if size < LEAST_FILE:
        reason = f"{shorten(value)} is too little for a recording: give 1 MB or more"
        raise RefusedError(reason)
    return size


def rate_of(value: object) -> float:
    """The rate of "5", "5/s" or "0.5 Hz" [1/s].

    Raises:
        RefusedError: It is none, or above 100.
    """
    text = re.sub(r"\s*(?:/\s*s|Hz)\s*$", "", value) if isinstance(value, str) else value
    return _amount(text, {"": 1.0}, "", 100.0, "a rate up to 100/s, such as '5/s'")


def split_of(value: object) -> tuple[float, int]:
    """When a file is full: after a span of time [s], or at a size [bytes]; the other is 0.

    Raises:
        RefusedError: It is neither, or less than a megabyte.
    """
    for read, place in ((seconds_of, 0), (bytes_of, 1)):
        try:
            amount = read(value)
        except RefusedError:
            continue
        if amount > 0:
            return (amount, 0) if place == 0 else (0.0, file_bytes_of(value))
    reason = f"{shorten(value)} is neither a span of time such as '10 min' nor a size as '500 MB'"
    raise RefusedError(reason)


def size_of(value: object) -> tuple[int, int]:
    """Width and height of "320x240" or [320, 240] [pixels].

    Raises:
        RefusedError: It is no size from 1 to 8192 pixels.
    """
    parts = value.split("x") if isinstance(value, str) else value
    if isinstance(parts, list) and len(parts) == 2:
        texts = [str(part).strip() for part in parts]
        if all(text.isascii() and text.isdigit() and len(text) < 6 for text in texts):
            width, height = map(int, texts)
            if min(width, height) >= 1 and max(width, height) <= 8192:
                return width, height
    reason = f"{shorten(value)} is no width and height of 1 to 8192 pixels, such as 320x240"
    raise RefusedError(reason)


def pattern_of(value: object) -> re.Pattern[str]:
    """A regular expression.

    Raises:
        RefusedError: It is none, or too long.
    """
    if isinstance(value, str) and 0 < len(value) <= 1000:
        try:
            return re.compile(value)
        except (re.error, RecursionError, OverflowError) as error:
            reason = f"{shorten(value)} is no regular expression: {error}"
            raise RefusedError(reason) from error
    reason = f"{shorten(value)} is no regular expression of up to 1000 characters"
    raise RefusedError(reason)


def said(read: Reader, allowed: str) -> Within:
    """A reader of the robot file, with its values for people."""
    return Within(read, allowed)


def _amount(
    value: object, units: Mapping[str, float], plain: str, most: float, allowed: str
) -> float:
    """A number with a unit; a number alone is in the unit `plain`.

    Raises:
        RefusedError: It is none, or above `most`.
    """
    if isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value <= most:
        return float(value)
    match = _AMOUNT.fullmatch(value) if isinstance(value, str) and len(value) < 40 else None
    unit = match and units.get(match[2] or plain)
    if match is not None and unit is not None and float(match[1]) * unit <= most:
        return float(match[1]) * unit
    reason = f"{shorten(value)} is not {allowed}"
    raise RefusedError(reason)
