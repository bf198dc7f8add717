"""Lines of tables, and JSON, that spreadsheets and readers of JSON take as they are meant."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, Final

from hub.plain_text import plain

_FORMULA: Final = re.compile(r"'*\s*[=+\-@\uff0b\uff0d\uff1d\uff20]|'*[\t\r\n]")
"""The begin of what spreadsheets take for a formula; Excel takes wide letters too."""
_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|[+-]?inf", re.IGNORECASE)
_QUOTED: Final = re.compile(r'[,;"\t\r\n]|^\s|\s$')
"""What needs quotes: also the separators of spreadsheets in other languages."""


def csv_line(cells: Iterable[object], end: str = "\r\n", separator: str = ",") -> str:
    """A line of a CSV file (RFC 4180).

    Args:
        cells: Its cells; texts may be those of others, None is an empty cell.
        end: The end of the line.
        separator: Stands between two cells.
    """
    return separator.join(_quoted(cell_text(each)) for each in cells) + end


def cell_text(cell: object) -> str:
    """The text of a cell: an apostrophe precedes a formula, control characters are spelt out."""
    if cell is None:
        return ""
    if not isinstance(cell, str):
        return str(cell)
    text = plain(cell, lines=True)
    return f"'{text}" if _FORMULA.match(text) and not _NUMBER.fullmatch(text) else text


def text_of_cell(cell: str) -> str:
    """The text that `cell_text` made a cell of."""
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell) else cell


def json_text(value: object, **options: Any) -> str:  # noqa: ANN401 - those of json.dumps
    """A value as JSON; numbers that JSON has not are the texts "nan", "inf" and "-inf"."""
    try:
        return json.dumps(value, allow_nan=False, **options)
    except ValueError:
        return json.dumps(_finite(value), allow_nan=False, **options)


def _finite(value: object) -> object:
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else str(float(value))
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if _QUOTED.search(text) else text
