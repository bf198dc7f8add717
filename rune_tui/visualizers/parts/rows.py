"""Words in rows: cut, wrapped, or side by side in columns, as the room allows."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Sequence

from hub.values import dataclass
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.visualizers.parts.severity import Severity, ink_of

GAP = 2
"""Blanks between columns of a table, and between words that share a row."""
NARROW = 60
"""Columns of a canvas below which free text in a table gets rows of its own."""

_TROUBLE = frozenset({Severity.WARNING, Severity.ALARM})
_ELLIPSIS = "…"
LEAST_TEXT = 12
"""Room that free text in the last column of a table needs [cells]."""


@dataclass(frozen=True, slots=True)
class TextRow:
    """One row of words.

    Attributes:
        text: Its text.
        severity: Its severity.
        continues: Whether it belongs to the row above it.
    """

    text: str
    severity: Severity = Severity.PLAIN
    continues: bool = False


def cut(text: str, columns: int) -> str:
    """The text, with an ellipsis in place of words that do not fit; only a single word is cut."""
    shown = printable_text(text)
    if len(shown) <= columns:
        return shown
    words = shown[: max(0, columns - 1)]
    if not shown[len(words) :].startswith(" ") and " " in words.strip():
        words = words.rpartition(" ")[0]
    return f"{words.rstrip()}{_ELLIPSIS}"[: max(0, columns)]


def cut_anywhere(text: str, columns: int) -> str:
    """The text, with an ellipsis in place of letters that do not fit."""
    shown = printable_text(text)
    if len(shown) <= columns:
        return shown
    return f"{shown[: max(0, columns - 1)].rstrip()}{_ELLIPSIS}"[: max(0, columns)]


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of a table.

    Attributes:
        cells: Its texts.
        why: The reason; in the last column, or below the entry if that has a fault and room is
            short.
        severity: Its severity.
    """

    cells: tuple[str, ...]
    why: str = ""
    severity: Severity = Severity.PLAIN


def fitting_form(columns: int, *forms: str) -> str:
    """The first of several texts that fits, else the last one, cut."""
    return next((form for form in forms if len(printable_text(form)) <= columns), "") or cut(
        forms[-1], columns
    )


def wrapped(row: TextRow, columns: int, indent: str = "  ") -> Iterator[TextRow]:
    """A row wrapped to several; rows after the first are indented."""
    indent = indent if columns >= 4 * len(indent) else ""
    text = printable_text(row.text)
    lines = textwrap.wrap(text, max(1, columns), subsequent_indent=indent)
    for index, line in enumerate(lines):
        yield TextRow(line, row.severity, row.continues or index > 0)


def flowing(words: Iterable[TextRow], columns: int) -> Iterator[tuple[TextRow, ...]]:
    """Short words side by side, as many on each row as fit."""
    line: list[TextRow] = []
    used = 0
    for word in words:
        length = len(printable_text(word.text))
        if line and used + GAP + length > columns:
            yield tuple(line)
            line, used = [], 0
        used += length + (GAP if line else 0)
        line.append(word)
    if line:
        yield tuple(line)


def kept_columns(
    cells: Sequence[Sequence[str]], weights: Sequence[int], columns: int, least: int = LEAST_TEXT
) -> dict[int, int]:
    """The width [cells] of each column of a table that has room, by its number.

    Empty columns are left out; with little room those of least weight too.

    Args:
        cells: The cells of each row.
        weights: The weight of each column.
        columns: The room [cells].
        least: Room that the last column needs for the words that decide [cells].
    """
    widths = [max(len(printable_text(cell)) for cell in column) for column in zip(*cells)]  # noqa: B905
    last = len(widths) - 1

    def room(index: int) -> int:
        return min(widths[index], least) if index == last else widths[index]

    kept = [index for index, width in enumerate(widths) if width]
    while len(kept) > 1 and sum(map(room, kept)) + GAP * (len(kept) - 1) > columns:
        kept.remove(min(kept, key=lambda index: weights[index]))
    return {index: widths[index] for index in kept}


def tabled(
    cells: Sequence[Sequence[str]], weights: Sequence[int], columns: int, least: int = LEAST_TEXT
) -> tuple[str, ...]:
    """Rows of cells in aligned columns, as `kept_columns` says; the last one is cut."""
    kept = kept_columns(cells, weights, columns, least).items()
    return tuple(
        cut(
            (" " * GAP).join(printable_text(row[i]).ljust(width) for i, width in kept).rstrip(),
            columns,
        )
        for row in cells
    )


def entry_rows(entries: Sequence[Entry], weights: Sequence[int], columns: int) -> Iterator[TextRow]:
    """A table of entries; `weights` as for `tabled`, with the reason last."""
    if columns >= NARROW:
        lines = tabled([(*entry.cells, entry.why) for entry in entries], weights, columns)
    else:
        lines = tabled([entry.cells for entry in entries], weights[:-1], columns)
    for entry, line in zip(entries, lines, strict=True):
        yield TextRow(line, entry.severity)
        if columns < NARROW and entry.why and entry.severity in _TROUBLE:
            yield from wrapped(TextRow(f"  {entry.why}", entry.severity, continues=True), columns)


def write_rows(canvas: Canvas, rows: Sequence[TextRow], theme: Theme) -> None:
    """Write rows from the top; the last one counts the entries that follow, where it has room."""
    for index, row in enumerate(rows[: canvas.rows]):
        canvas.text(0, index, cut(row.text, canvas.width), ink_of(row.severity, theme))
    if left_out := sum(not row.continues for row in rows[canvas.rows :]):
        more, used = f" +{left_out}", len(printable_text(rows[canvas.rows - 1].text))
        if used + len(more) <= canvas.width:
            canvas.text(canvas.width - len(more), canvas.rows - 1, more, theme.faint)
