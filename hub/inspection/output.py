"""How the commands write answers to requests, tables and spans of time."""

from __future__ import annotations

from collections.abc import Sequence

from hub.command_output import print_error, put
from hub.gcm.common import CommonResult
from hub.plain_text import plain


def outcome(result: CommonResult) -> int:
    """The exit code for an answer to a request; a refusal is printed on standard error."""
    if result.done:
        return 0
    print_error(plain(result.text))
    return 1


def report(result: CommonResult) -> int:
    """Print an answer to a request; returns the exit code."""
    if result.done:
        put(plain(result.text))
    return outcome(result)


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], *, words: int = 1) -> None:
    """Write columns as wide as they need to be.

    Args:
        heads: What stands above them.
        rows: A text for each column.
        words: How many columns, counted from the left, hold words; numbers stand to the right.
    """
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    for row in (heads, *rows):
        cells = [
            cell.ljust(width) if place < words else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        put("  ".join(cells).rstrip())


def span(seconds: float) -> str:
    """A span of time in the unit that suits it."""
    for unit, name in ((86_400.0, "d"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * unit:
            return f"{seconds / unit:.1f} {name}"
    return f"{seconds:.1f} s"
