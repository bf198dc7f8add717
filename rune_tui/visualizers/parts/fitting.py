"""Parts in the rows of a pane: the most important words are the last to be cut.

| rows are short | action |
| --- | --- |
| no | show the longest form of each part, wrapped |
| yes | show the longest form that fits one row; parts of the least weight first |
| still | put short forms side by side, except what is wrong |
| still | leave out parts of the least weight; " +2" counts them where it has room |
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final

from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.parts.rows import GAP, TextRow, cut, fitting_form, wrapped
from rune_tui.visualizers.parts.severity import Part, Severity, ink_of

Row = tuple[TextRow, ...]
"""Words side by side in one row."""

_TAIL: Final = re.compile(r" \([^()]*\)$")
_TROUBLE: Final = frozenset({Severity.WARNING, Severity.ALARM})
_MARKS: Final = ("; ", ", ", ": ")


def clauses(text: str) -> tuple[str, ...]:
    """A text, then without what is in brackets at its end, then with fewer clauses."""
    forms = [text]
    while found := _TAIL.search(forms[-1]):
        forms.append(forms[-1][: found.start()])
    for mark in _MARKS:
        while mark in forms[-1]:
            forms.append(forms[-1].rpartition(mark)[0])
    return tuple(forms)


def forms_of(part: Part) -> tuple[str, ...]:
    """The forms of a part, the longest first; each has the word or number that decides."""
    return (part.text, part.short) if part.short else clauses(part.text)


def fitted(parts: Sequence[Part], columns: int, room: int) -> list[Row]:
    """The rows of a pane.

    Args:
        parts: What the pane says, in its order.
        columns: Width of the pane [cells].
        room: Its height [cells].
    """
    rows = _in_rows(parts, columns, room)
    if len(rows) <= room:
        return rows
    groups: list[tuple[Part, ...]] = [(part,) for part in parts]
    while len(groups) > max(1, room):
        pairs = [place for place in range(1, len(groups)) if _fit_abreast(groups, place, columns)]
        if pairs:
            place = min(pairs, key=lambda each: _weight((*groups[each - 1], *groups[each])))
            groups[place - 1 : place + 1] = [(*groups[place - 1], *groups[place])]
        else:
            groups.remove(min(reversed(groups), key=_weight))
    rows = [
        _shortest(group)
        if len(group) > 1
        else (_word(group[0], fitting_form(columns, *forms_of(group[0]))),)
        for group in groups[: max(0, room)]
    ]
    return [*_counted(rows, len(parts) - sum(map(len, groups)), columns)]


def _in_rows(parts: Sequence[Part], columns: int, room: int) -> list[Row]:
    """Each part in rows of its own; those of the least weight are shortened first."""
    blocks = [[*wrapped(TextRow(part.text, part.severity), columns)] for part in parts]
    order = sorted(range(len(parts)), key=lambda place: (parts[place].weight, -place))
    for place in order:
        if sum(map(len, blocks)) <= room:
            break
        blocks[place] = [_word(parts[place], fitting_form(columns, *forms_of(parts[place])))]
    return [(row,) for block in blocks for row in block]


def _fit_abreast(groups: Sequence[tuple[Part, ...]], place: int, columns: int) -> bool:
    """Whether this group and the one before it fit one row, and none says what is wrong."""
    both = (*groups[place - 1], *groups[place])
    calm = all(part.severity not in _TROUBLE for part in both)
    return calm and _width(_shortest(both)) <= columns


def _weight(group: tuple[Part, ...]) -> float:
    return max(part.weight for part in group)


def _shortest(parts: Sequence[Part]) -> Row:
    return tuple(_word(part, forms_of(part)[-1]) for part in parts)


def _word(part: Part, text: str) -> TextRow:
    return TextRow(text, part.severity)


def _width(row: Row) -> int:
    return sum(len(printable_text(word.text)) + GAP for word in row) - GAP


def _counted(rows: Sequence[Row], hidden: int, columns: int) -> Iterator[Row]:
    """The rows; the last one counts the parts that are left out, where it has room."""
    yield from rows[:-1]
    for row in rows[-1:]:
        more = TextRow(f"+{hidden}", Severity.FAINT)
        yield (*row, more) if hidden and _width((*row, more)) <= columns else row


def write_fitted(canvas: Canvas, parts: Sequence[Part], theme: Theme, top: int = 0) -> None:
    """Write the rows of `fitted` from a row on; an alarm has the alarm's plate."""
    rows = fitted(parts, canvas.width, canvas.rows - top) if parts else []
    for number, row in enumerate(rows, start=top):
        plate = row[0].severity is Severity.ALARM
        if plate:
            with drawing(canvas) as pen:
                pen.rectangle(0, 2 * number, canvas.width, 2 * number + 2, theme.alarm)
        column = 0
        for word in row:
            text = cut(word.text, canvas.width - column)
            ink = theme.on_alarm if plate else ink_of(word.severity, theme)
            canvas.text(column, number, text, ink)
            column += len(text) + GAP
