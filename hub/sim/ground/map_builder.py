"""Builds the height map of an arena from the tables of its file."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hub.sim.geometry import Box, Surface
from hub.sim.ground.elements import Floats, relief_of
from hub.sim.ground.height_field import NO_DECK, HeightField
from hub.sim.ground.specs import DeckSpec, ElementSpec, GripSpec, GroundSpec, PipeSpec

MAX_CELLS = 4_000_000
"""Largest number of cells of a height map."""
_MARGIN = 0.5
"""Level floor around all elements [m], wider than the largest wheel."""
_ROUNDING = 1e-6

_Item = ElementSpec | DeckSpec | GripSpec


def build_ground(spec: GroundSpec, floor: Surface) -> HeightField | None:
    """The height map of an arena; None where its ground is level and grips everywhere alike."""
    if not _items(spec):
        return None
    builder = _MapBuilder(spec.terrain.cell, _items(spec), floor)
    for element in spec.elements:
        builder.raise_to(element)
    for grip in spec.grips:
        builder.cover(grip)
    for deck in spec.decks:
        builder.put_above(deck)
    return builder.field(spec.decks)


def level_ground() -> HeightField:
    """A level floor, for bases in an arena without rough ground."""
    floor = Surface(texture="plain", colour=(0, 0, 0))
    return _MapBuilder(GroundSpec().terrain.cell, (), floor).field(())


def map_size(spec: GroundSpec) -> tuple[int, int]:
    """Rows and columns of the height map."""
    return _extent(spec.terrain.cell, _items(spec))[1]


def _items(spec: GroundSpec) -> tuple[_Item, ...]:
    return (*spec.elements, *spec.decks, *spec.grips)


def _extent(cell: float, items: Sequence[_Item]) -> tuple[tuple[float, float], tuple[int, int]]:
    """South-west corner of the map [m], a whole number of cells from 0; rows and columns."""
    first, count = [], []
    for axis in (0, 1):
        lows = [item.at[axis] for item in items] or [0.0]
        highs = [item.at[axis] + item.extent[axis] for item in items] or [0.0]
        begin = math.floor((min(lows) - _MARGIN) / cell + _ROUNDING)
        first.append(begin * cell)
        count.append(math.ceil((max(highs) + _MARGIN) / cell - _ROUNDING) - begin)
    return (first[0], first[1]), (count[1], count[0])


class _MapBuilder:
    """A height map in the making."""

    def __init__(self, cell: float, items: Sequence[_Item], floor: Surface) -> None:
        self._cell = cell
        self._origin, shape = _extent(cell, items)
        self._x: Floats = self._origin[0] + (np.arange(shape[1], dtype=np.float64) + 0.5) * cell
        self._y: Floats = self._origin[1] + (np.arange(shape[0], dtype=np.float64) + 0.5) * cell
        self._heights, self._east, self._north = (np.zeros(shape, np.float32) for _ in range(3))
        self._grip = np.ones(shape, np.float32)
        self._decks, self._undersides = (np.full(shape, NO_DECK) for _ in range(2))
        self._appearance = np.zeros(shape, np.uint16)
        self._surfaces = [floor]

    def raise_to(self, element: ElementSpec) -> None:
        """Raise the ground to an element where that is higher."""
        part = self._covered(element)
        relief = relief_of(
            element, self._x[part[1]] - element.at[0], self._y[part[0]] - element.at[1]
        )
        higher = relief.heights >= self._heights[part]
        for whole, values in (
            (self._heights, relief.heights),
            (self._east, relief.east),
            (self._north, relief.north),
        ):
            whole[part] = np.where(higher, values, whole[part])
        self._appearance[part][higher] = self._number(element.texture, element.colour)
        turns = isinstance(element, PipeSpec) and element.turning
        self._grip[part][higher] = 0.0 if turns else 1.0

    def cover(self, cover: GripSpec) -> None:
        """Change the grip, and the appearance where the file says so."""
        part = self._covered(cover)
        self._grip[part] *= np.float32(cover.grip)
        if cover.texture is None and cover.colour is None:
            return
        before = self._appearance[part].copy()
        for number in np.unique(before).tolist():
            seen = self._surfaces[number]
            changed = self._number(cover.texture or seen.texture, cover.colour or seen.colour)
            self._appearance[part][before == number] = changed

    def put_above(self, deck: DeckSpec) -> None:
        """Put a deck above the ground."""
        part = self._covered(deck)
        self._decks[part] = deck.height
        self._undersides[part] = deck.height - deck.thickness

    def field(self, decks: Sequence[DeckSpec]) -> HeightField:
        """The finished map."""
        for array in (
            self._heights,
            self._east,
            self._north,
            self._grip,
            self._appearance,
            self._decks,
            self._undersides,
        ):
            array.setflags(write=False)
        return HeightField(
            heights=self._heights,
            east=self._east,
            north=self._north,
            cell=self._cell,
            origin=self._origin,
            grip=self._grip,
            appearance=self._appearance,
            surfaces=tuple(self._surfaces),
            decks=self._decks if decks else None,
            undersides=self._undersides if decks else None,
            deck_boxes=tuple(_deck_box(deck) for deck in decks),
        )

    def _covered(self, item: _Item) -> tuple[slice, slice]:
        """The rows and columns of the cells whose middles an item covers."""
        columns, rows = (
            slice(*np.searchsorted(places, (at - _ROUNDING, at + size - _ROUNDING)).tolist())
            for places, at, size in zip((self._x, self._y), item.at, item.extent, strict=True)
        )
        return rows, columns

    def _number(self, texture: str, colour: tuple[int, int, int]) -> int:
        """Number of an appearance; 0 is that of the floor alone."""
        surface = Surface(texture=texture, colour=colour)
        if surface not in self._surfaces[1:]:
            self._surfaces.append(surface)
        return self._surfaces.index(surface, 1)


def _deck_box(deck: DeckSpec) -> Box:
    (x, y), (width, depth) = deck.at, deck.size
    return Box(
        low=(x, y, deck.height - deck.thickness),
        high=(x + width, y + depth, deck.height),
        surface=Surface(texture=deck.texture, colour=deck.colour),
    )
