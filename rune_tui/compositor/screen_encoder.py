"""Frames to terminal bytes: only what the terminal does not show yet, as exactly as is wanted."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from rune_tui.compositor.block_merge import merged
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import UPPER_HALF
from rune_tui.compositor.looks import Flags, Looks, Numbers, any_channel, looks_of, unpacked
from rune_tui.compositor.moves import Moves
from rune_tui.compositor.planes import planes_of
from rune_tui.compositor.quality import EXACT, Quality
from rune_tui.compositor.sgr import FORMS, RESET
from rune_tui.compositor.word_matrix import WordMatrix
from rune_tui.raster.urgency import Urgencies

_WHOLE = 0.98
"""From this share of cells on, sending all is as good: each one left out costs a move."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Remembered:
    """What was known of a terminal.

    Attributes:
        shown: What it showed; None if nothing was known.
        known: Where that was known, shape (rows, columns).
        depth: In which colours.
    """

    shown: Looks | None
    known: Flags
    depth: ColourDepth


class ScreenEncoder:
    """Knows what the terminal shows, and makes the bytes that bring it to a frame.

    The bytes expect the terminal's attributes to be reset and leave them so; they move the cursor,
    and nowhere else than into the cells that they write. Whatever else is written to these cells
    has to be told with `forget`.
    """

    def __init__(self, *, top: int = 0, left: int = 0, half: str = UPPER_HALF) -> None:
        """Prepare; nothing is known of what the terminal shows.

        Args:
            top: Rows of the terminal above the frame.
            left: Columns of the terminal left of it.
            half: `UPPER_HALF` or `LOWER_HALF`: the block that shows two pixels in truecolour. Some
                fonts draw one of them with seams. With fewer colours both are needed.
        """
        self._top, self._left, self._half = top, left, half
        self._matrix = WordMatrix()
        self._shown: Looks | None = None
        self._depth = ColourDepth.TRUECOLOUR
        self._known: Flags = np.zeros((0, 0), np.bool_)
        self._moves = Moves((0, 0), top=top, left=left)

    def forget(self, where: Flags | None = None) -> None:
        """The terminal may show anything; the next frame is sent anew there.

        Args:
            where: Which cells, shape (rows, columns); None for all, as is any other shape than that
                of the frame before.
        """
        if where is None or where.shape != self._known.shape:
            self._shown = None
            self._known[...] = False
        else:
            self._known &= ~where

    def wrong(self, frame: Cells | Looks, threshold: int) -> Flags:
        """Where the terminal shows a frame too badly, shape (rows, columns).

        Args:
            frame: Cells, or their looks if they were taken already.
            threshold: As in a `Quality`.
        """
        looks = frame if isinstance(frame, Looks) else looks_of(frame)
        return _wrong(looks, self._fitted(looks), threshold) | ~self._known

    @property
    def remembered(self) -> Remembered:
        """What is known of the terminal now, to `return_to`."""
        return Remembered(shown=self._shown, known=self._known.copy(), depth=self._depth)

    def return_to(self, before: Remembered) -> None:
        """What was encoded since then will not be written."""
        if before.known.shape == self._known.shape:
            self._shown, self._known, self._depth = before.shown, before.known.copy(), before.depth
        else:
            self.forget()

    def encode(
        self,
        frame: Cells | Looks,
        quality: Quality = EXACT,
        covered: Flags | None = None,
        *,
        only: Flags | None = None,
        urgencies: Urgencies | None = None,
        most: int | None = None,
    ) -> bytes:
        """What brings the terminal to a frame, in UTF-8; empty if it shows it well enough.

        The same frame in a better quality sends what is not good enough yet. A frame of another
        size or depth than the one before is sent whole.

        Args:
            frame: Cells, or their looks if they were taken already.
            quality: How exact it has to be.
            covered: Cells that something else covers, shape (rows, columns): they are left out,
                and not known from then on.
            only: Cells that are looked at, shape (rows, columns); the others stay as they are.
            urgencies: Cells of smaller ones are written first; None writes in reading order.
            most: So many cells are written at most, if there are `urgencies`.
        """
        looks = frame if isinstance(frame, Looks) else looks_of(frame)
        shown = self._fitted(looks)
        if looks.depth is not ColourDepth.TRUECOLOUR:
            quality = EXACT
        send = _wrong(looks, shown, quality.threshold) | ~self._known
        open_to_all = covered is None or not covered.any()
        if covered is not None:
            self._known &= ~covered
            send &= ~covered
        if only is not None:
            send &= only
            open_to_all = False
        if quality.tolerance and send.any():
            looks = _simplified(looks, quality.tolerance)
            # What it has become may be there already.
            send &= looks.differs(shown) | ~self._known
        elif open_to_all and np.count_nonzero(send) >= _WHOLE * send.size:
            send[...] = True
        if not send.any():
            return b""
        numbers = None if send.all() and urgencies is None else np.flatnonzero(send)
        if numbers is not None and urgencies is not None:
            numbers = numbers[np.argsort(urgencies.ravel().take(numbers), kind="stable")][:most]
            send = np.zeros_like(send)
            send.ravel()[numbers] = True
        self._shown = looks if send.all() else shown.replaced(looks, send)
        self._known |= send
        return self._written(looks, numbers)

    def _fitted(self, looks: Looks) -> Looks:
        """What is shown, as a frame of the size and depth of this one."""
        fits = self._depth is looks.depth and self._known.shape == looks.glyphs.shape
        if self._shown is not None and fits:
            return self._shown
        if self._known.shape != looks.glyphs.shape:
            self._moves = Moves(looks.glyphs.shape, top=self._top, left=self._left)
        self._depth = looks.depth
        self._known = np.zeros(looks.glyphs.shape, np.bool_)
        self._shown = looks  # of which nothing is known yet
        return looks

    def _written(self, looks: Looks, numbers: Numbers | None) -> bytes:
        """The bytes of the cells of these numbers, in this order; of all if there are none."""
        form = FORMS[self._depth]
        if numbers is None:
            moves = self._moves.to_rows
        else:
            moves = self._moves.to(numbers)
            looks = looks.taken(numbers)
        planes = planes_of(looks, form, self._half)
        joined = self._matrix.joined(planes, form, moves, anew=False)
        return joined + RESET if planes.background[-1, -1] != form.at_start else joined


def _wrong(looks: Looks, shown: Looks, threshold: int) -> Flags:
    """Which cells look too different from what is shown."""
    if not threshold:
        return looks.differs(shown)
    cut = bool(looks.shapes.any() or shown.shapes.any())
    # Shapes alone say nothing: of two like colours, it is all one where they lie.
    wanted = unpacked(looks.quarters if cut else looks.pixels)
    there = unpacked(shown.quarters if cut else shown.pixels)
    off = np.maximum(wanted, there)
    off -= np.minimum(wanted, there)
    far = any_channel(off > threshold)
    wrong: Flags = far[0::2] | far[1::2]
    wrong = wrong[:, 0::2] | wrong[:, 1::2] if cut else wrong
    if looks.written or shown.written:
        wrong |= ((looks.glyphs != 0) | (shown.glyphs != 0)) & looks.differs(shown)
    return wrong


def _simplified(looks: Looks, tolerance: int) -> Looks:
    """Fewer colours where there are no characters."""
    pixels = merged(looks.pixels, tolerance)
    if looks.written:
        text = np.repeat(looks.glyphs != 0, 2, axis=0)
        np.copyto(pixels, looks.pixels, where=text)
    shapes = np.where(pixels[0::2] == pixels[1::2], np.uint8(0), looks.shapes)
    return dataclasses.replace(looks, pixels=pixels, shapes=shapes)
