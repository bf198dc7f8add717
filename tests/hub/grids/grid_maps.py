"""Small maps for tests, drawn with letters or by hypothesis."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from hub.grids.grid import Grid

LETTERS = {".": 0, "#": 100, "?": -1}


def drawn(*rows: str, resolution: float = 0.1) -> Grid:
    """A map with its corner at the origin: the first row is the one of the greatest y."""
    cells = np.array([[LETTERS[letter] for letter in row] for row in reversed(rows)], np.int8)
    return Grid(cells=cells, resolution=resolution, origin_x=0.0, origin_y=0.0)


@st.composite
def maps(draw: st.DrawFn, most: int = 24, walls: float = 0.25) -> Grid:
    """A random map of free, occupied and unknown cells."""
    height, width = draw(st.integers(3, most)), draw(st.integers(3, most))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    share = draw(st.floats(0.0, walls))
    kinds = np.array([0, 100, -1], np.int8)
    cells = random.choice(kinds, (height, width), p=[1.0 - 1.2 * share, share, 0.2 * share])
    return Grid(cells=cells, resolution=0.1, origin_x=-1.0, origin_y=2.0)
