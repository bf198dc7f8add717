"""Maps of a condition as SVG: walls, paths, bumps, victims and time of all participants; pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from hub.plain_text import counted, markup
from hub.sim.arena import Footprints
from hub.values import dataclass
from rune_study.data.overlay import CELL_M, Cell, TrialOverlay
from rune_study.statistics.arrays import Floats

_CM = 100.0
"""A map's units are centimetres, so that whole numbers suffice."""
_LEVELS = (0.12, 0.26, 0.4, 0.54, 0.68)
"""Opacities of time spent, from little to much."""
_HUE = 137.508
"""Between the colours of two participants, so that neighbours differ [deg]."""
_ROOM_M = 0.5
_SCALES_M = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionMap:
    """A map, and what it shows in numbers.

    Attributes:
        svg: The picture.
        words: The same for those who do not see it.
        trials: Number of trials.
        driven: Length of all paths [m].
        bumps: Number of bumps.
        found: Victims found, over all trials.
        victims: Victims that could be found, over all trials.
        false: Marks without a victim.
    """

    svg: str
    words: str
    trials: int
    driven: float
    bumps: int
    found: int
    victims: int
    false: int


def colours_of(participants: Iterable[int]) -> dict[int, str]:
    """A colour for each participant, readable on light and dark ground."""
    return {
        person: f"hsl({(210 + _HUE * number) % 360:.0f} 70% 42%)"
        for number, person in enumerate(sorted(set(participants)))
    }


def longest_stay(groups: Iterable[Sequence[TrialOverlay]]) -> float:
    """Longest time in a cell, as the mean over the trials of a group [s]."""
    return max((max(_stays(group).values(), default=0.0) for group in groups), default=0.0)


def condition_map(
    title: str,
    overlays: Sequence[TrialOverlay],
    walls: Footprints | None,
    colours: Mapping[int, str],
    *,
    number: int,
    most: float,
) -> ConditionMap:
    """The map of trials in one arena.

    Args:
        title: What the trials have in common.
        overlays: The trials, one at least.
        walls: Obstacles of the arena; None: it is not known.
        colours: Of each participant.
        number: Of the map on its page.
        most: Time in a cell that has the strongest colour [s].
    """
    plan = _Plan(_bounds(overlays, walls))
    shares = _found(overlays)
    of_victims = [f"{found:.0f} of {len(overlays)}" for *_, found in shares]
    found = sum(int(each.found.sum()) for each in overlays)
    victims = sum(len(each.victims) for each in overlays)
    false = sum(len(each.false) for each in overlays)
    bumps = sum(len(each.bumps) for each in overlays)
    driven = sum(each.driven for each in overlays)
    words = (
        f"{counted(len(overlays), 'trial')}, {driven:.0f} m driven, {counted(bumps, 'bump')}, "
        f"{counted(false, 'mark')} without a victim. "
        f"{_victims_in_words(of_victims)} {'' if walls else 'The walls are not known.'}"
    ).strip()
    parts = [
        *_heat(plan, _stays(overlays), most),
        *(() if walls is None else [_walls(plan, walls)]),
        *_paths(plan, overlays, colours),
        *_marks(plan, overlays, colours),
        *_victims(plan, shares, len(overlays)),
        _scale(plan),
    ]
    names = f"map{number}-title map{number}-words"
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {plan.width} {plan.height}" '
        f'role="img" aria-labelledby="{names}" font-family="sans-serif" '
        f'font-size="{plan.text}" class="map">'
        f'<title id="map{number}-title">{markup(title)}</title>'
        f'<desc id="map{number}-words">{markup(words)}</desc>'
        f'<rect width="{plan.width}" height="{plan.height}" fill="#fff" class="paper"/>'
        f"{''.join(parts)}</svg>"
    )
    return ConditionMap(
        svg=svg,
        words=words,
        trials=len(overlays),
        driven=driven,
        bumps=bumps,
        found=found,
        victims=victims,
        false=false,
    )


class _Plan:
    """Turns metres of the arena into centimetres of the picture, y down."""

    def __init__(self, bounds: tuple[float, float, float, float]) -> None:
        self.left, low, right, self.top = bounds
        self.width = math.ceil((right - self.left) * _CM)
        self.height = math.ceil((self.top - low) * _CM)
        self.text = max(1, max(self.width, self.height) // 30)

    def at(self, x: float, y: float) -> tuple[int, int]:
        return round((x - self.left) * _CM), round((self.top - y) * _CM)


def _bounds(
    overlays: Sequence[TrialOverlay], walls: Footprints | None
) -> tuple[float, float, float, float]:
    """Least x and y, greatest x and y [m]: of the arena, else of all that is drawn."""
    parts: list[Floats] = []
    if walls is not None:
        round_ones = walls.radius[:, None]
        parts += [walls.low, walls.high, walls.centre - round_ones, walls.centre + round_ones]
    if not any(map(len, parts)):
        for each in overlays:
            parts += [*each.paths, each.bumps, each.victims, each.false]
    points = np.concatenate([each.reshape(-1, 2) for each in parts])
    if not len(points):
        return -_ROOM_M, -_ROOM_M, _ROOM_M, _ROOM_M
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    return x0 - _ROOM_M, y0 - _ROOM_M, x1 + _ROOM_M, y1 + _ROOM_M


def _stays(overlays: Sequence[TrialOverlay]) -> dict[Cell, float]:
    """Mean time of a trial in each cell [s]."""
    found: dict[Cell, float] = {}
    for each in overlays:
        for cell, seconds in each.stays.items():
            found[cell] = found.get(cell, 0.0) + seconds / len(overlays)
    return found


def _heat(plan: _Plan, stays: Mapping[Cell, float], most: float) -> Iterator[str]:
    """Cells by the time that was spent there; short times differ more than long ones."""
    cells: list[list[str]] = [[] for _ in _LEVELS]
    edge = round(CELL_M * _CM)
    for (column, row), seconds in sorted(stays.items()):
        if seconds > 0.0 < most:
            level = min(int(len(_LEVELS) * math.sqrt(seconds / most)), len(_LEVELS) - 1)
            x, y = plan.at(column * CELL_M, (row + 1) * CELL_M)
            cells[level].append(f"M{x} {y}h{edge}v{edge}h-{edge}z")
    for opacity, found in zip(_LEVELS, cells, strict=True):
        if found:
            yield f'<path class="stay" fill="#e09a1a" opacity="{opacity}" d="{"".join(found)}"/>'


def _walls(plan: _Plan, walls: Footprints) -> str:
    parts = []
    for (x0, y0), (x1, y1) in zip(walls.low.tolist(), walls.high.tolist(), strict=True):
        left, top = plan.at(x0, y1)
        right, bottom = plan.at(x1, y0)
        width, height = max(1, right - left), max(1, bottom - top)
        parts.append(f"M{left} {top}h{width}v{height}h-{width}z")
    for (x, y), radius in zip(walls.centre.tolist(), walls.radius.tolist(), strict=True):
        left, middle = plan.at(x - radius, y)
        size = max(1, round(radius * _CM))
        arc = f"a{size} {size} 0 1 0"
        parts.append(f"M{left} {middle}{arc} {2 * size} 0{arc} -{2 * size} 0z")
    return f'<path class="wall" fill="#555b63" d="{"".join(parts)}"/>'


def _paths(
    plan: _Plan, overlays: Sequence[TrialOverlay], colours: Mapping[int, str]
) -> Iterator[str]:
    for each in overlays:
        if not each.paths:
            continue
        lines = "".join(_line(plan, path) for path in each.paths)
        title = (
            f"participant {each.participant}, trial {each.trial}: {each.driven:.0f} m, "
            f"{len(each.bumps)} bumps"
        )
        yield (
            f'<path class="way" fill="none" stroke="{colours[each.participant]}" '
            f'stroke-width="1.3" vector-effect="non-scaling-stroke" stroke-linejoin="round" '
            f'd="{lines}"><title>{title}</title></path>'
        )


def _line(plan: _Plan, path: Floats) -> str:
    """A path whose points are given by the differences to those before."""
    x, y = plan.at(*path[0].tolist())
    words = [f"M{x} {y}l"]
    for point in path[1:].tolist():
        next_x, next_y = plan.at(*point)
        words.append(f"{next_x - x} {next_y - y}")
        x, y = next_x, next_y
    return words[0] + " ".join(words[1:]).replace(" -", "-")


def _marks(
    plan: _Plan, overlays: Sequence[TrialOverlay], colours: Mapping[int, str]
) -> Iterator[str]:
    """Bumps as crosses, marks without a victim as diamonds, in the participant's colour."""
    size = max(1, plan.text // 3)
    for each in overlays:
        bumps = "".join(
            f"M{x - size} {y - size}l{2 * size} {2 * size}m0-{2 * size}l-{2 * size} {2 * size}"
            for x, y in (plan.at(*place) for place in each.bumps.tolist())
        )
        false = "".join(
            f"M{x} {y - size}l{size} {size}-{size} {size}-{size}-{size}z"
            for x, y in (plan.at(*place) for place in each.false.tolist())
        )
        for kind, shapes in (("bump", bumps), ("false mark", false)):
            if shapes:
                yield (
                    f'<path class="way" fill="none" stroke="{colours[each.participant]}" '
                    f'stroke-width="2.2" vector-effect="non-scaling-stroke" d="{shapes}">'
                    f"<title>{kind}: participant {each.participant}, trial {each.trial}</title>"
                    "</path>"
                )


def _found(overlays: Sequence[TrialOverlay]) -> list[tuple[float, float, float]]:
    """Place of each victim, and in how many of the trials it was found."""
    places = overlays[0].victims
    counts = np.sum([each.found for each in overlays if len(each.found) == len(places)], axis=0)
    return [
        (x, y, float(count))
        for (x, y), count in zip(places.tolist(), np.atleast_1d(counts).tolist(), strict=False)
    ]


def _victims(
    plan: _Plan, shares: Iterable[tuple[float, float, float]], trials: int
) -> Iterator[str]:
    """Victims as circles, filled by how often they were found."""
    size = max(1, plan.text // 2)
    for place_x, place_y, found in shares:
        x, y = plan.at(place_x, place_y)
        yield (
            f"<g><title>victim, found in {found:.0f} of {trials} trials</title>"
            f'<circle class="victim" cx="{x}" cy="{y}" r="{size}" fill="#1f8a4c" '
            f'fill-opacity="{0.15 + 0.8 * found / trials:.2f}" stroke="#1f8a4c" '
            f'stroke-width="1.5" vector-effect="non-scaling-stroke"/>'
            f'<text class="halo" x="{x + size + plan.text // 6}" y="{y + plan.text // 3}" '
            f'stroke="#fff" stroke-width="{plan.text // 4}" paint-order="stroke">'
            f"{found:.0f}/{trials}</text></g>"
        )


def _victims_in_words(found: Sequence[str]) -> str:
    if not found:
        return "No victim is known."
    return f"Victims were found in {', '.join(found)} trials."


def _scale(plan: _Plan) -> str:
    """A bar of a round length, at most a quarter of the width."""
    metres = max((each for each in _SCALES_M if each * _CM <= plan.width / 4), default=_SCALES_M[0])
    x, y = plan.text // 2, plan.height - plan.text // 2
    return (
        f'<path class="scale" fill="none" stroke="#181c22" stroke-width="2" '
        f'vector-effect="non-scaling-stroke" d="M{x} {y}h{metres * _CM:.0f}"/>'
        f'<text x="{x}" y="{y - plan.text // 3}">{metres:g} m</text>'
    )
