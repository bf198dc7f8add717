"""The tables of a study as one spreadsheet file, of the extra `xlsx`."""

from __future__ import annotations

import dataclasses
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from hub import files
from hub.plain_text import plain
from rune_study.data.rows import TABLES
from rune_study.data.store import StudyData, wide_rows
from rune_study.errors import DataError
from rune_study.metrics.registry import METRICS

_WIDEST = 400
"""Widest column [px]."""


def write_xlsx(data: StudyData, path: Path) -> Path:
    """Write a file with a sheet for each table, and one that explains all columns.

    Args:
        data: The data of the study.
        path: The file.

    Returns:
        The file.

    Raises:
        DataError: The extra is not installed, or the file cannot be written.
    """
    try:
        import xlsxwriter
    except ImportError as fault:
        text = "--xlsx needs XlsxWriter; install it with pip install 'robot-user-nexus[xlsx]'"
        raise DataError(text) from fault
    whole = io.BytesIO()
    book = xlsxwriter.Workbook(whole, {"in_memory": True})
    bold = book.add_format({"bold": True})
    for name, rows in _sheets(data):
        sheet = book.add_worksheet(name)
        sheet.freeze_panes(1, 0)
        for line, cells in enumerate(rows):
            for column, cell in enumerate(cells):
                _write(sheet, (line, column), cell, None if line else bold)
        sheet.autofit(_WIDEST)
    book.close()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        files.replace(path, whole.getvalue())
    except OSError as fault:
        text = f"{path} cannot be written: {fault.strerror or fault}"
        raise DataError(text) from fault
    return path


def _write(sheet: Any, at: tuple[int, int], cell: object, form: object) -> None:  # noqa: ANN401 - of a library without types
    """Write a cell; a text is never a formula or an address, and no number leaves it empty."""
    if isinstance(cell, int | float) and math.isfinite(cell):
        sheet.write_number(*at, cell, form)
    elif isinstance(cell, float) and math.isinf(cell):
        sheet.write_string(*at, "inf" if cell > 0 else "-inf", form)
    elif isinstance(cell, str):
        sheet.write_string(*at, plain(cell, lines=True), form)


def _sheets(data: StudyData) -> Iterable[tuple[str, Iterable[Sequence[object]]]]:
    tables = {"trials.csv": data.trials, "metrics.csv": data.metrics, "probes.csv": data.probes}
    for name, rows in tables.items():
        columns = [each.name for each in dataclasses.fields(TABLES[name])]
        cells = [[getattr(row, each) for each in columns] for row in rows]
        yield Path(name).stem, [columns, *cells]
    yield "wide", wide_rows(data)
    yield "dictionary", [["table", "name", "meaning", "unit"], *_meanings()]


def _meanings() -> Iterable[list[object]]:
    for name, kind in TABLES.items():
        for each in dataclasses.fields(kind):
            yield [name, each.name, each.metadata["meaning"], each.metadata["unit"]]
    for metric, about in METRICS.items():
        yield ["metrics.csv, wide.csv", metric, about.words, about.unit]
