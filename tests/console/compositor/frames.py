"""Random frames of cells."""

from __future__ import annotations

import dataclasses

import numpy as np
from hypothesis import strategies as st

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.looks import looks_of, unpacked
from rune_tui.raster.canvas import halved

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


def refined(cells: Cells, seed: int, *, steps: tuple[int, ...] = (0, 0, 2, 60)) -> Cells:
    """The cells with finer pixels, some of them so far from their mean [levels]."""
    random = np.random.default_rng(seed)
    off = random.choice(np.array(steps), cells.pixels.shape[:2])[..., None] * np.array([1, 1, 1, 0])
    off *= random.choice([-1, 1], cells.pixels.shape)
    pixels = cells.pixels.astype(int)
    fine = np.stack([pixels - off, pixels + off], axis=2).clip(0, 255).astype(np.uint8)
    fine = fine.reshape(2 * cells.rows, 2 * cells.columns, 4)
    return dataclasses.replace(cells, pixels=halved(fine), fine=fine)


def as_drawn(cells: Cells) -> Cells:
    """The cells with the finer pixels that quadrants show of them."""
    if cells.fine is None:
        return cells
    return dataclasses.replace(cells, fine=unpacked(looks_of(cells).quarters))


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
