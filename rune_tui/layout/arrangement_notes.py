"""The report of `rune check` on arrangements: their sizes, and doubtful places.

A note is no mistake: the console still opens the layout.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

from rune_tui.layout.grammar import quoted
from rune_tui.layout.placing import Placed, placed
from rune_tui.layout.spec import CHOSEN, ArrangementSpec, LayoutSpec, ViewportSpec

_MOST_COMPARED = 100
"""Viewports of an arrangement that are compared with each other: the work grows with its square."""
_USUAL = (80, 24)
"""A terminal that every arrangement without a least size has to do with [cells]."""
_INVISIBLE = 255


def arrangement_notes(layout: LayoutSpec) -> Iterator[str]:
    """A line for each arrangement with a name, and the doubts about it."""
    vital = _vital(layout)
    for arrangement in layout.view.arrangements:
        if arrangement.name:
            yield _summary(arrangement)
        for doubt in dict.fromkeys(_doubts(arrangement, layout, vital)):
            within = f"{arrangement.name}: " if arrangement.name else ""
            yield f"note: {within}{doubt}"
    placed_somewhere = {
        place.viewport for each in layout.view.arrangements for place in each.places
    }
    for viewport in layout.view.viewports:
        if viewport.visualizer and viewport.name not in placed_somewhere:
            yield f"note: viewport {quoted(viewport.name)} is placed nowhere, so it is never drawn"


def _summary(arrangement: ArrangementSpec) -> str:
    count = len(arrangement.places)
    viewports = "1 viewport" if count == 1 else f"{count} viewports"
    least = f"from {arrangement.min_columns} columns and {arrangement.min_rows} rows"
    return f"arrangement {arrangement.name}: {least}, {viewports}"


def _vital(layout: LayoutSpec) -> dict[str, str]:
    """Names of vital viewports, with their visualizers and robots."""
    found = {}
    for viewport in layout.view.viewports:
        shown = viewport.visualizer
        if shown and layout.vocabulary.visualizers[shown.function].rule.vital:
            found[viewport.name] = f"{shown.function} of {_owner_words(viewport)}"
    return found


def _owner_words(viewport: ViewportSpec) -> str:
    return "the chosen robot" if viewport.robot == CHOSEN else f"robot {quoted(viewport.robot)}"


def _doubts(
    arrangement: ArrangementSpec, layout: LayoutSpec, vital: dict[str, str]
) -> Iterator[str]:
    here = {place.viewport for place in arrangement.places}
    shown_here = {words for name, words in vital.items() if name in here}
    for words in dict.fromkeys(vital.values()):
        if words not in shown_here:
            yield f"no {words}, which the layout has elsewhere; it is needed at every size"
    known = {viewport.name: viewport for viewport in layout.view.viewports}
    drawn = [
        place
        for place in arrangement.places
        if place.visible and place.transparency < _INVISIBLE and known[place.viewport].visualizer
    ]
    if len(drawn) > _MOST_COMPARED:
        yield f"{len(drawn)} viewports are too many to be compared with each other"
        return
    kept = {place.viewport for place in drawn}
    kinds = layout.vocabulary.visualizers
    free = {
        name
        for name in kept
        if (shown := known[name].visualizer)
        and not getattr(kinds[shown.function], "whole_cells", True)
    }
    for columns, rows in _sizes(arrangement):
        there = [
            each
            for each in placed(arrangement, columns, rows, free=free)
            if each.spec.viewport in kept
        ]
        yield from _collisions(there, known, f"at {columns} x {rows}")


def _sizes(arrangement: ArrangementSpec) -> Sequence[tuple[int, int]]:
    """The size of the design, and the smallest terminal that takes it, in cells."""
    design = (arrangement.xsize, -(-arrangement.ysize // 2))
    said = (arrangement.min_columns, arrangement.min_rows)
    least = [said[axis] if said[axis] > 1 else min(_USUAL[axis], design[axis]) for axis in range(2)]
    return (design, (least[0], least[1]))


def _collisions(
    there: Sequence[Placed], known: dict[str, ViewportSpec], where: str
) -> Iterator[str]:
    for one, other in combinations(there, 2):
        first, second = known[one.spec.viewport], known[other.spec.viewport]
        of_robots = all(each.visualizer and each.visualizer.message for each in (first, second))
        pair = f"{quoted(first.name)} and {quoted(second.name)}"
        if one.spec.zpos == other.spec.zpos and one.area.meets(other.area):
            yield f"{pair} overlap {where} and have the same zpos"
        elif (
            first.robot != second.robot
            and one.area.touches(other.area)
            and of_robots
            and not _parted(one, other, known)
        ):
            yield f"{pair} show different robots and touch; leave a gap"


def _parted(one: Placed, other: Placed, known: dict[str, ViewportSpec]) -> bool:
    """Whether the title of the lower one stands between them."""
    upper, lower = sorted((one, other), key=lambda each: each.area.y)
    below = upper.area.y + upper.area.height <= lower.area.y
    return below and bool(known[lower.spec.viewport].title)
