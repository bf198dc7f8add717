"""Random frames of cells, and pictures in them."""

from __future__ import annotations

import dataclasses

import numpy as np
from hypothesis import strategies as st

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.raster.placed_picture import PlacedPicture

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


def with_picture(
    cells: Cells, seed: int, *, steps: tuple[int, ...] = (0, 0, 2, 60)
) -> tuple[Cells, tuple[SeenPicture, ...]]:
    """The cells as they show a picture with two pixels across each of theirs.

    Args:
        cells: What the picture is like.
        seed: Of what is random.
        steps: How far the picture's pixels may be off their mean [levels].
    """
    random = np.random.default_rng(seed)
    off = random.choice(np.array(steps), cells.pixels.shape[:2])[..., None]
    off = off * random.choice([-1, 1], (*off.shape[:2], 3))
    pixels = cells.pixels[..., :3].astype(int)
    pair = np.stack([pixels - off, pixels + off], axis=2).clip(0, 255).astype(np.uint8)
    return in_quadrants(pair.reshape(2 * cells.rows, 2 * cells.columns, 3), cells)


def in_quadrants(
    pixels: np.ndarray, cells: Cells | None = None
) -> tuple[Cells, tuple[SeenPicture, ...]]:
    """Cells full of a picture, and the picture.

    Args:
        pixels: With two of them across one of the cells', shape (2 * rows, 2 * columns, 3).
        cells: Have the characters; None: there are none.
    """
    picture = PlacedPicture.of(pixels, 0, 0, (2, 1))
    cells = cells or flat(pixels.shape[1] // 2, len(pixels) // 2, 0)
    seen = SeenPicture(picture=picture, seen=cells.glyphs == 0)
    return dataclasses.replace(cells, pixels=picture.means), (seen,)


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
