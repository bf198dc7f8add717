"""Random frames of cells."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from rune_tui.compositor.cells import Cells

GLYPHS = [32, 33, 65, 0xB0, 0x416, 0x2588, 0x2580, 0x1D400]


def random_cells(seed: int, columns: int, rows: int, colours: int, written: float) -> Cells:
    """Cells of few colours, so that neighbours are often equal, some with characters."""
    random = np.random.default_rng(seed)
    palette = random.integers(0, 256, (colours, 4), np.uint8)
    glyphs = random.choice(np.array(GLYPHS, np.uint32), (rows, columns))
    glyphs[random.random((rows, columns)) >= written] = 0
    return Cells(
        pixels=palette[random.integers(0, colours, (2 * rows, columns))],
        glyphs=glyphs,
        ink=palette[random.integers(0, colours, (rows, columns))],
    )


def flat(columns: int, rows: int, *colour: int) -> Cells:
    """Cells of one colour, or of one grey."""
    pixels = np.zeros((2 * rows, columns, 4), np.uint8)
    pixels[..., :3] = colour
    return Cells(
        pixels=pixels,
        glyphs=np.zeros((rows, columns), np.uint32),
        ink=np.zeros((rows, columns, 4), np.uint8),
    )


frames = st.builds(
    random_cells,
    st.integers(0, 100_000),
    st.integers(1, 14),
    st.integers(1, 6),
    st.integers(1, 5),
    st.sampled_from([0.0, 0.2, 1.0]),
)
