"""How the commands write to standard output: lines, tables, spans of time."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from hub.gcm.common import CommonResult


def put(line: str) -> None:
    """Write a line, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def outcome(result: CommonResult) -> int:
    """The exit code for an answer to a request; a refusal is told on standard error."""
    if result.done:
        return 0
    sys.stderr.write(f"rune-hub: {printable(result.text)}\n")
    return 1


def printable(text: str) -> str:
    """A text of others on one line: it may hold anything, also what a terminal obeys."""
    return "".join(c if c.isprintable() else "?" for c in text)


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
