"""The arrangement for a terminal, and the places of viewports on it; pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Iterator, Sequence

from hub.values import dataclass
from rune_tui.layout.spec import ArrangementSpec, PlaceSpec

_SHARE_OF_STRIP = 4
"""Full screen leaves at most one row in this many for vital viewports."""
_NARROW_ROWS = 2
"""Rows of a vital viewport in full screen that is not a line over the whole view."""
_LEAST_COLUMNS = 24
"""Least width of vital viewports in full screen [cells]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Area:
    """A rectangle of the terminal's pixel grid (columns, 2 * rows) [pixels]."""

    x: int
    y: int
    width: int
    height: int

    def meets(self, other: Area) -> bool:
        """Whether both have a pixel in common."""
        across = self.x < other.x + other.width and other.x < self.x + self.width
        down = self.y < other.y + other.height and other.y < self.y + self.height
        return across and down

    def touches(self, other: Area) -> bool:
        """Whether they touch, side by side or one above the other."""
        if self.meets(other):
            return False
        across = self.x <= other.x + other.width and other.x <= self.x + self.width
        down = self.y < other.y + other.height and other.y < self.y + self.height
        along = self.x < other.x + other.width and other.x < self.x + self.width
        below = self.y <= other.y + other.height and other.y <= self.y + self.height
        return (across and down) or (along and below)


@dataclass(frozen=True, slots=True, kw_only=True)
class Placed:
    """A viewport on the terminal.

    Attributes:
        spec: The arrangement's values for it.
        area: Where it is.
    """

    spec: PlaceSpec
    area: Area


def arrangement_for(
    arrangements: Iterable[ArrangementSpec], columns: int, rows: int
) -> ArrangementSpec:
    """The largest arrangement that a terminal has room for, else the smallest.

    Args:
        arrangements: One or more.
        columns: Width of the terminal [cells].
        rows: Height of the terminal [cells].
    """
    ordered = sorted(arrangements, key=lambda each: (each.min_columns, each.min_rows))
    fitting = (
        each for each in reversed(ordered) if each.min_columns <= columns and each.min_rows <= rows
    )
    return next(fitting, ordered[0])


def area_of(
    place: PlaceSpec, design: tuple[int, int], columns: int, rows: int, *, whole_cells: bool
) -> Area:
    """The place of a design on a terminal.

    Edges scale, so viewports that touch in the design touch on the terminal; unscaled viewports
    keep their size and scale their upper left corner. A place wholly inside the design is kept
    wholly inside the terminal, if it fits.

    Args:
        place: The place.
        design: Width and height of the design [pixels].
        columns: Width of the terminal [cells].
        rows: Height of the terminal [cells].
        whole_cells: Whether it must be made of whole cells, so that text in it is not cut.
    """
    x, width = _span(place.xpos, place.xsize, design[0], columns, step=1, scaled=place.scaled)
    y, height = _span(
        place.ypos,
        place.ysize,
        design[1],
        2 * rows,
        step=2 if whole_cells else 1,
        scaled=place.scaled,
    )
    return Area(x=x, y=y, width=width, height=height)


def placed(
    arrangement: ArrangementSpec, columns: int, rows: int, *, free: Collection[str] = ()
) -> tuple[Placed, ...]:
    """The places of all viewports of an arrangement.

    Args:
        arrangement: The places.
        columns: Width of the terminal [cells].
        rows: Height of the terminal [cells].
        free: Viewports that need not be made of whole cells.
    """
    return _on_design(
        arrangement.places, (arrangement.xsize, arrangement.ysize), columns, rows, free
    )


def given_away(places: Sequence[PlaceSpec], idle: Collection[str]) -> tuple[PlaceSpec, ...]:
    """The places without those of idle viewports, whose room goes to a place beside them.

    A place grows over an idle one in one direction, if it then covers no other place. The nearest
    one is chosen, of these the one that gains the most. What lies over another viewport leaves no
    room.

    Args:
        places: The places of an arrangement.
        idle: Viewports that can show nothing.
    """
    kept = [place for place in places if place.viewport not in idle]
    holes = [
        place
        for place in places
        if place.viewport in idle and not any(_meet(place, each) for each in kept)
    ]
    while holes:
        hole = holes.pop(0)
        grown = [
            (number, larger)
            for number, place in enumerate(kept)
            if place.scaled
            for larger in _over(place, hole)
            if not any(
                _meet(larger, each) and not _meet(place, each) for each in kept if each is not place
            )
        ]
        if grown:
            number, larger = min(grown, key=lambda each: _effort(kept[each[0]], hole, each[1]))
            kept[number] = larger
            holes = [each for each in holes if not _meet(larger, each)]
    return tuple(kept)


def _over(place: PlaceSpec, hole: PlaceSpec) -> Iterator[PlaceSpec]:
    """The place, grown over a hole that lies below, above, right or left of it."""
    right, bottom = place.xpos + place.xsize, place.ypos + place.ysize
    hole_right, hole_bottom = hole.xpos + hole.xsize, hole.ypos + hole.ysize
    if place.xpos <= hole.xpos and hole_right <= right:
        if hole.ypos >= bottom:
            yield dataclasses.replace(place, ysize=hole_bottom - place.ypos)
        elif hole_bottom <= place.ypos:
            yield dataclasses.replace(place, ypos=hole.ypos, ysize=bottom - hole.ypos)
    if place.ypos <= hole.ypos and hole_bottom <= bottom:
        if hole.xpos >= right:
            yield dataclasses.replace(place, xsize=hole_right - place.xpos)
        elif hole_right <= place.xpos:
            yield dataclasses.replace(place, xpos=hole.xpos, xsize=right - hole.xpos)


def _meet(one: PlaceSpec, other: PlaceSpec) -> bool:
    return _area(one).meets(_area(other))


def _area(place: PlaceSpec) -> Area:
    return Area(x=place.xpos, y=place.ypos, width=place.xsize, height=place.ysize)


def _effort(place: PlaceSpec, hole: PlaceSpec, larger: PlaceSpec) -> tuple[int, int]:
    """Key of an order: near places first, then those that gain the most."""
    across = max(hole.xpos - place.xpos - place.xsize, place.xpos - hole.xpos - hole.xsize)
    down = max(hole.ypos - place.ypos - place.ysize, place.ypos - hole.ypos - hole.ysize)
    gain = larger.xsize * larger.ysize - place.xsize * place.ysize
    return max(across, down), -gain


def filled(
    arrangement: ArrangementSpec,
    full: str,
    vital: Sequence[str],
    columns: int,
    rows: int,
    *,
    free: Collection[str] = (),
) -> tuple[Placed, ...]:
    """The places of viewports while one of them fills the view.

    Viewports over it stay over it. The other vital viewports get a strip
    at the lower edge; nothing else is shown.

    Args:
        arrangement: The usual places.
        full: The viewport that fills the view.
        vital: Viewports that the operator must see, the most important first.
        columns: Width of the terminal [cells].
        rows: Height of the terminal [cells].
        free: Viewports that need not be made of whole cells.
    """
    known = {place.viewport: place for place in arrangement.places}
    whole = PlaceSpec(
        viewport=full, xpos=0, ypos=0, xsize=arrangement.xsize, ysize=arrangement.ysize
    )
    ground = known.get(full, whole)
    over = tuple(_lying_over(ground, arrangement.places)) if full in known else ()
    kept = {place.viewport for place in over}
    apart = [known[name] for name in vital if name in known and name not in {*kept, full}]
    strip = tuple(_strip(apart, arrangement.xsize, columns, rows))
    left = min((each.area.y // 2 for each in strip), default=rows)
    moved = tuple(
        dataclasses.replace(each, xpos=each.xpos - ground.xpos, ypos=each.ypos - ground.ypos)
        for each in over
    )
    filling = Placed(spec=ground, area=Area(x=0, y=0, width=columns, height=2 * left))
    above = _on_design(moved, (ground.xsize, ground.ysize), columns, left, free)
    return (filling, *above, *strip)


def _on_design(
    places: Iterable[PlaceSpec],
    design: tuple[int, int],
    columns: int,
    rows: int,
    free: Collection[str],
) -> tuple[Placed, ...]:
    return tuple(
        Placed(
            spec=place,
            area=area_of(place, design, columns, rows, whole_cells=place.viewport not in free),
        )
        for place in places
    )


def _lying_over(ground: PlaceSpec, places: Sequence[PlaceSpec]) -> Iterator[PlaceSpec]:
    """The places above another place, with their middle over it."""
    behind = places.index(ground)
    for number, place in enumerate(places):
        nearer = (place.zpos, number) > (ground.zpos, behind)
        across = 2 * place.xpos + place.xsize - 2 * ground.xpos
        down = 2 * place.ypos + place.ysize - 2 * ground.ypos
        inside = 0 <= across < 2 * ground.xsize and 0 <= down < 2 * ground.ysize
        if nearer and inside:
            yield place


def _strip(
    places: Sequence[PlaceSpec], design_width: int, columns: int, rows: int
) -> Iterator[Placed]:
    """Places in rows at the lower edge, the most important at the bottom and to the left."""
    room = max(1, rows // _SHARE_OF_STRIP)
    lines = [place for place in places if 2 * place.xsize > design_width]
    narrow = [place for place in places if 2 * place.xsize <= design_width]
    bottom = rows
    for place in lines[:room]:
        bottom -= 1
        room -= 1
        yield Placed(spec=place, area=Area(x=0, y=2 * bottom, width=columns, height=2))
    abreast = max(1, columns // _LEAST_COLUMNS)
    while narrow and room:
        taken, narrow = narrow[:abreast], narrow[abreast:]
        height = min(_NARROW_ROWS, room)
        bottom -= height
        room -= height
        for number, place in enumerate(taken):
            left, right = (columns * edge // len(taken) for edge in (number, number + 1))
            area = Area(x=left, y=2 * bottom, width=right - left, height=2 * height)
            yield Placed(spec=place, area=area)


def _span(
    start: int, size: int, design: int, actual: int, *, step: int, scaled: bool
) -> tuple[int, int]:
    """First pixel and length on the terminal, both multiples of `step`."""
    first = _scaled(start, design, actual, step)
    length = _scaled(start + size, design, actual, step) - first
    if not scaled:
        length = -(-size // step) * step
    length = max(step, length)
    if start >= 0 and start + size <= design:
        first = max(0, min(first, actual - length))
    return first, length


def _scaled(position: int, design: int, actual: int, step: int) -> int:
    """round(position * actual / design) to a multiple of `step`, halves up."""
    return (2 * position * actual + design * step) // (2 * design * step) * step
