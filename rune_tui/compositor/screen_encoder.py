"""Encodes the changes between the terminal's screen and a frame as bytes."""

from __future__ import annotations

import dataclasses

import numpy as np

from hub.values import dataclass
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
"""Share of changed cells from which all are sent, as each gap costs a cursor move."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Remembered:
    """A saved state of the encoder.

    Attributes:
        shown: The terminal's screen; None if unknown.
        known: Cells where it is known, shape (rows, columns).
        depth: Colour depth.
    """

    shown: Looks | None
    known: Flags
    depth: ColourDepth


class ScreenEncoder:
    """Remembers the terminal's screen, and encodes the changes that lead to a frame.

    The bytes expect reset attributes and leave them reset. They move the cursor only to the cells
    that they write. A caller that writes to the screen itself calls `forget` after.
    """

    def __init__(self, *, top: int = 0, left: int = 0, half: str = UPPER_HALF) -> None:
        """Prepare; the screen is unknown at first.

        Args:
            top: Rows of the terminal above the frame.
            left: Columns of the terminal left of it.
            half: Half block for truecolour, `UPPER_HALF` or `LOWER_HALF`; some fonts draw one of
                them with seams.
        """
        self._top, self._left, self._half = top, left, half
        self._matrix = WordMatrix()
        self._shown: Looks | None = None
        self._depth = ColourDepth.TRUECOLOUR
        self._known: Flags = np.zeros((0, 0), np.bool_)
        self._moves = Moves((0, 0), top=top, left=left)

    def forget(self, where: Flags | None = None) -> None:
        """Treat cells as unknown, so that the next frame sends them again.

        Args:
            where: Flags of shape (rows, columns); None, or the shape of another frame: all cells.
        """
        if where is None or where.shape != self._known.shape:
            self._shown = None
            self._known[...] = False
        else:
            self._known &= ~where

    def wrong(self, frame: Cells | Looks, threshold: int) -> Flags:
        """Cells that the terminal shows with a larger error than the threshold of a `Quality`."""
        looks = frame if isinstance(frame, Looks) else looks_of(frame)
        return _wrong(looks, self._fitted(looks), threshold) | ~self._known

    @property
    def remembered(self) -> Remembered:
        """The state now, for `return_to`."""
        return Remembered(shown=self._shown, known=self._known.copy(), depth=self._depth)

    def return_to(self, before: Remembered) -> None:
        """Return to an earlier state: the bytes encoded since then will not be written."""
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
        """Bytes that lead the terminal to a frame, in UTF-8; empty if it is exact enough already.

        The same frame in a better quality sends only the corrections. A frame of another size or
        depth is sent whole.

        Args:
            frame: Cells or their looks.
            quality: Exactness.
            covered: Cells under another screen, shape (rows, columns): they are not sent, and are
                unknown after.
            only: Cells to send, shape (rows, columns); all other cells stay.
            urgencies: Urgency of each cell, which gives the order; None: reading order.
            most: Largest number of cells, with `urgencies` only.
        """
        looks = frame if isinstance(frame, Looks) else looks_of(frame)
        shown = self._fitted(looks)
        if looks.depth is not ColourDepth.TRUECOLOUR:
            quality = EXACT
        send = _wrong(looks, shown, quality.threshold) | ~self._known
        complete = covered is None or not covered.any()
        if covered is not None:
            self._known &= ~covered
            send &= ~covered
        if only is not None:
            send &= only
            complete = False
        if quality.tolerance and send.any():
            looks = _simplified(looks, quality.tolerance)
            # The merged colours may be on the screen already.
            send &= looks.differs(shown) | ~self._known
        elif complete and np.count_nonzero(send) >= _WHOLE * send.size:
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
        """The terminal's screen, in the size and depth of this frame."""
        fits = self._depth is looks.depth and self._known.shape == looks.glyphs.shape
        if self._shown is not None and fits:
            return self._shown
        if self._known.shape != looks.glyphs.shape:
            self._moves = Moves(looks.glyphs.shape, top=self._top, left=self._left)
        self._depth = looks.depth
        self._known = np.zeros(looks.glyphs.shape, np.bool_)
        self._shown = looks  # all cells are unknown
        return looks

    def _written(self, looks: Looks, numbers: Numbers | None) -> bytes:
        """Bytes of the cells of these numbers, in this order; without numbers, of all cells."""
        form = FORMS[self._depth]
        if numbers is None:
            moves = self._moves.to_rows
        else:
            moves = self._moves.to(numbers)
            looks = looks.taken(numbers)
        planes = planes_of(looks, form, self._half)
        joined = self._matrix.joined(planes, form, moves, reset=False)
        return joined + RESET if planes.background[-1, -1] != form.at_start else joined


def _wrong(looks: Looks, shown: Looks, threshold: int) -> Flags:
    """Cells with a larger error than the threshold."""
    if not threshold:
        return looks.differs(shown)
    cut = bool(looks.shapes.any() or shown.shapes.any())
    # Shapes alone do not decide: with two similar colours, the shape makes no difference.
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
    """Looks with similar neighbours merged, except in cells with characters."""
    pixels = merged(looks.pixels, tolerance)
    if looks.written:
        text = np.repeat(looks.glyphs != 0, 2, axis=0)
        np.copyto(pixels, looks.pixels, where=text)
    shapes = np.where(pixels[0::2] == pixels[1::2], np.uint8(0), looks.shapes)
    return dataclasses.replace(looks, pixels=pixels, shapes=shapes)
