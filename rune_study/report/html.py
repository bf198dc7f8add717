"""Parts of a page as HTML: tables, numbers, intervals, and the style of all of it; pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from hub.plain_text import markup
from rune_study.estimate import Estimate

STYLE = """
:root { color-scheme: light dark; --ink: #181c22; --paper: #fff; --line: #c4c8cc; --block: #f2f3f5 }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 62em; padding: 0 1em;
  color: var(--ink); background: var(--paper); overflow-wrap: break-word }
table { border-collapse: collapse }
caption { text-align: left; font-weight: 600; padding: .2em 0 }
th, td { text-align: left; padding: .2em .7em; vertical-align: top }
td { border-bottom: 1px solid var(--line) }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
.wide { overflow-x: auto; margin: .6em 0 }
svg { width: 100%; height: auto; display: block; margin: .5em 0; border: 1px solid var(--line) }
figure { margin: 0; min-width: 0 }
.pictures { display: grid; gap: 1em;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 24em), 1fr)) }
.legend { list-style: none; padding: 0; display: flex; flex-wrap: wrap; gap: .2em 1em }
.legend span { display: inline-block; width: 1.4em; height: .3em; vertical-align: middle }
pre { overflow-x: auto; background: var(--block); padding: .6em }
h3 { margin-top: 2em; border-top: 1px solid var(--line); padding-top: .6em }
@media (prefers-color-scheme: dark) {
  :root { --ink: #dfe3e8; --paper: #14171b; --line: #3d434b; --block: #1d2126 }
  svg .paper { fill: #14171b } svg text { fill: #dfe3e8 } svg .scale { stroke: #dfe3e8 }
  svg .halo { stroke: #14171b }
  svg .wall { fill: #8a9099 } svg .axis { stroke: #8a9099 }
  svg .data, svg .way, .legend span { filter: brightness(1.5) }
}
@media print {
  :root { color-scheme: light } body { max-width: none; margin: 0; font-size: 10pt }
  .wide, pre { overflow: visible } pre { white-space: pre-wrap }
  svg, tr, figure { break-inside: avoid } h2, h3 { break-after: avoid }
}
"""
"""For light and dark screens, narrow ones, and paper."""


def page(title: str, parts: Iterable[str]) -> str:
    """A page that stands alone.

    Args:
        title: Of the page.
        parts: Its content.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{markup(title)}</title><style>{STYLE}</style></head>\n<body>\n<main>\n"
        + "\n".join(parts)
        + "\n</main>\n</body>\n</html>\n"
    )


def paragraph(text: str) -> str:
    """A paragraph."""
    return f"<p>{markup(text)}</p>"


def table(heads: Sequence[str], rows: Iterable[Sequence[str]], *, caption: str = "") -> str:
    """A table; on a narrow screen it scrolls by itself.

    Args:
        heads: Of the columns.
        rows: Cells.
        caption: What it shows; empty: the text before it says so.
    """
    above = f"<caption>{markup(caption)}</caption>" if caption else ""
    head = "".join(f'<th scope="col">{markup(each)}</th>' for each in heads)
    lines = "".join(
        "<tr>" + "".join(f"<td{_class(cell)}>{markup(cell)}</td>" for cell in row) + "</tr>"
        for row in rows
    )
    return f'<div class="wide"><table>{above}<tr>{head}</tr>{lines}</table></div>'


def _class(cell: str) -> str:
    try:
        float(cell.strip("<"))
    except ValueError:
        return ""
    return ' class="number"'


def number(value: float) -> str:
    """A number with three digits; a dash where there is none."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def interval(estimate: Estimate) -> str:
    """The ends of an interval; a dash where there is none."""
    if not estimate.has_interval:
        return "–"
    return "\N{NO-BREAK SPACE}".join((number(estimate.low), "to", number(estimate.high)))


def p_value(value: float) -> str:
    """A p-value with three digits."""
    if math.isnan(value):
        return "–"
    return "<0.001" if value < 0.001 else f"{value:.3f}"


def people(numbers: Iterable[int]) -> str:
    """Participants by their numbers: "participant 3", "participants 3, 5"."""
    listed = [str(each) for each in numbers]
    return f"participant{'s' if len(listed) > 1 else ''} {', '.join(listed)}"
