"""Tables on pages that are made from the code."""

from __future__ import annotations

import itertools
import os
from pathlib import Path


def put_table(lines: list[str], heading: str, rows: list[str]) -> None:
    """Put rows in place of those of the table behind a line that begins so."""
    starts = [place for place, line in enumerate(lines) if line.startswith(heading)]
    assert starts, f"no line begins with {heading}"
    first = next(n for n in itertools.count(starts[-1]) if lines[n].startswith("|")) + 2
    last = next(n for n in itertools.count(first) if not lines[n].startswith("|"))
    lines[first:last] = rows


def check_page(path: Path, lines: list[str]) -> None:
    """A page has these lines; write them where RUNE_WRITE_SNAPSHOTS is set."""
    wanted = "\n".join(lines) + "\n"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        path.write_text(wanted)
    assert path.read_text() == wanted, "write the tables anew, as the test's docstring says"
