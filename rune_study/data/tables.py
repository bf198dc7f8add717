"""Tables as files: CSV, or TSV by their name; and the dictionary of their columns."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from hub import files
from hub.table_text import cell_text, csv_line, text_of_cell
from rune_study.data.rows import TABLES
from rune_study.errors import DataError

T = TypeVar("T")
_MOST_BYTES = 256 * 1024 * 1024
_NOT_AVAILABLE = "n/a"


def as_text(name: str, rows: Iterable[object]) -> str:
    """A table as the text of its file; numbers that are none are empty, in TSV "n/a"."""
    tabs = name.endswith(".tsv")
    separator = "\t" if tabs else ","
    columns = _columns(name)
    lines = [columns, *([_cell(getattr(row, each), tabs=tabs) for each in columns] for row in rows)]
    return "".join(csv_line(line, "\n", separator) for line in lines)


def tsv(columns: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """Rows of any columns as BIDS wants them: without quotes, and "n/a" for an empty cell."""
    lines = [columns, *([_cell(each, tabs=True) for each in row] for row in rows)]
    cells = (
        [cell_text(" ".join(each.split())) or _NOT_AVAILABLE for each in line] for line in lines
    )
    return "".join("\t".join(line) + "\n" for line in cells)


def described(kind: Any, columns: Iterable[str]) -> dict[str, dict[str, Any]]:  # noqa: ANN401 - a dataclass of rows
    """What JSON says of columns: their meanings and units.

    Args:
        kind: The dataclass of a table's rows.
        columns: Their names.
    """
    by_name = {each.name: each.metadata for each in dataclasses.fields(kind)}
    return {
        name: {"Description": by_name[name]["meaning"]}
        | ({"Units": by_name[name]["unit"]} if by_name[name]["unit"] else {})
        for name in columns
    }


def write(folder: Path, name: str, rows: Iterable[object]) -> Path:
    """Write a table into a folder, as a whole or not at all.

    Raises:
        DataError: It cannot be written.
    """
    path = folder / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files.replace(path, as_text(path.name, rows).encode())
    except OSError as fault:
        text = f"{path} cannot be written: {fault.strerror or fault}"
        raise DataError(text) from fault
    return path


def read(path: Path, kind: type[T]) -> list[T]:
    """The rows of a table; columns are found by their names.

    Raises:
        DataError: It cannot be read, a column is missing, or a cell does not fit.
    """
    try:
        text = files.read_regular(path, _MOST_BYTES).decode("utf-8-sig")
    except (OSError, ValueError) as fault:
        reason = f"{path} cannot be read: {getattr(fault, 'strerror', None) or fault}"
        raise DataError(reason) from fault
    reader = csv.DictReader(io.StringIO(text), delimiter="\t" if path.suffix == ".tsv" else ",")
    columns = {each.name: each.type for each in dataclasses.fields(kind)}  # type: ignore[arg-type]
    missing = [name for name in columns if name not in (reader.fieldnames or ())]
    if missing:
        reason = f"{path} lacks the columns {', '.join(missing)}"
        raise DataError(reason)
    rows = []
    for line, cells in enumerate(reader, 2):
        try:
            rows.append(kind(**{name: _read(cells[name], columns[name]) for name in columns}))
        except (TypeError, ValueError) as fault:
            reason = f"{path}, line {line}: {fault}"
            raise DataError(reason) from fault
    return rows


def dictionary(metrics: Mapping[str, Mapping[str, str | float]]) -> str:
    """The data dictionary as JSON: tables with their columns, and metrics.

    Args:
        metrics: Of each metric, by its name: what describes it.
    """
    tables = {name: described(kind, _columns(name)) for name, kind in TABLES.items()}
    return json.dumps({"tables": tables, "metrics": metrics}, indent=2, ensure_ascii=False) + "\n"


def _columns(name: str) -> list[str]:
    return [each.name for each in dataclasses.fields(TABLES[name])]


def _cell(value: object, *, tabs: bool) -> str:
    if isinstance(value, float):
        if math.isnan(value):
            return _NOT_AVAILABLE if tabs else ""
        return repr(value)
    return " ".join(str(value).split("\n"))


def _read(cell: str | None, kind: Any) -> Any:  # noqa: ANN401 - the column's type
    if cell is None:
        text = "it has fewer cells than columns"
        raise ValueError(text)
    if kind in (float, "float"):
        return math.nan if cell in ("", _NOT_AVAILABLE) else float(cell)
    return int(cell) if kind in (int, "int") else text_of_cell(cell)
