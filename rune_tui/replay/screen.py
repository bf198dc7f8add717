"""The screen of a replay: the frame, a border that no live view has, and the timeline; pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.cells import Cells

HUE = (176, 32, 144)
"""The colour of the border; no theme has it."""
INK = (255, 255, 255)
GROUND = (24, 24, 28)
TOP, BOTTOM, SIDES = 1, 2, 1
"""Rows above and below the frame, and columns on each side [cells]."""


def room(columns: int, rows: int) -> tuple[int, int]:
    """Columns and rows that a terminal of this size has for the frame [cells]."""
    return max(1, columns - 2 * SIDES), max(1, rows - TOP - BOTTOM)


def framed(
    frame: Cells | None, columns: int, rows: int, head: str, timeline: Iterable[str]
) -> Cells:
    """The whole screen.

    Args:
        frame: The frame of the recording; None: there is none.
        columns: Width of the screen [cells].
        rows: Height of the screen [cells].
        head: The words of the first row.
        timeline: The two last rows.
    """
    cells = blank(columns, rows)
    border(cells)
    if frame is not None:
        wide, high = room(columns, rows)
        across, down = min(wide, frame.columns), min(high, frame.rows)
        left, top = SIDES + (wide - across) // 2, TOP + (high - down) // 2
        inside = slice(left, left + across)
        cells.pixels[2 * top : 2 * (top + down), inside] = frame.pixels[: 2 * down, :across]
        cells.glyphs[top : top + down, inside] = frame.glyphs[:down, :across]
        cells.ink[top : top + down, inside] = frame.ink[:down, :across]
    write(cells, 0, head)
    for number, text in enumerate(timeline):
        write(cells, rows - BOTTOM + number, text)
    return cells


def blank(columns: int, rows: int) -> Cells:
    """An empty screen."""
    pixels: npt.NDArray[np.uint8] = np.zeros((2 * rows, columns, 4), np.uint8)
    pixels[..., :3] = GROUND
    return Cells(
        pixels=pixels,
        glyphs=np.zeros((rows, columns), np.uint32),
        ink=np.zeros((rows, columns, 4), np.uint8),
    )


def border(cells: Cells) -> None:
    """Draw the border around a screen."""
    cells.pixels[: 2 * TOP, :, :3] = HUE
    cells.pixels[2 * (cells.rows - BOTTOM) :, :, :3] = HUE
    cells.pixels[:, :SIDES, :3] = HUE
    cells.pixels[:, cells.columns - SIDES :, :3] = HUE


def write(cells: Cells, row: int, text: str) -> None:
    """Write a text into a row of the border."""
    if not 0 <= row < cells.rows:
        return
    letters = np.array([ord(each) for each in text[: cells.columns]], np.uint32)
    cells.glyphs[row] = 0
    cells.glyphs[row, : len(letters)] = np.where(letters == ord(" "), 0, letters)
    cells.ink[row, :, :3] = INK


def write_page(cells: Cells, lines: Sequence[str]) -> None:
    """Write lines over the middle of the frame, as many as there is room for."""
    wide, high = room(cells.columns, cells.rows)
    shown = [f"  {line}"[:wide] for line in lines][:high]
    width = min(wide, max(map(len, shown), default=0) + 2)
    left, top = SIDES + (wide - width) // 2, TOP + (high - len(shown)) // 2
    inside = slice(left, left + width)
    cells.pixels[2 * top : 2 * (top + len(shown)), inside, :3] = HUE
    for row, line in enumerate(shown, top):
        letters = np.array([ord(each) for each in f"{line:<{width}}"[:width]], np.uint32)
        cells.glyphs[row, inside] = np.where(letters == ord(" "), 0, letters)
        cells.ink[row, inside, :3] = INK
