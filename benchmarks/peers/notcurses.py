"""notcurses, a C library for terminals; like Rune, it leaves out what the terminal already has.

`make bench-notcurses` builds it into the peers' own environment; one of the system does as well.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

LIBRARY = "libnotcurses-core.so.3"
_HALF_BLOCKS = 2  # NCBLIT_2x1
_SILENT = -1  # NCLOGLEVEL_SILENT
_ALONE = 0x0004 | 0x0008 | 0x0020  # no handlers of signals, no banners
_RASTER_BYTES = 4  # place of the bytes written among its statistics


class _Options(ctypes.Structure):
    """notcurses_options."""

    _fields_ = (
        ("termtype", ctypes.c_char_p),
        ("loglevel", ctypes.c_int),
        ("margins", ctypes.c_uint * 4),
        ("flags", ctypes.c_uint64),
    )


class _VisualOptions(ctypes.Structure):
    """ncvisual_options."""

    _fields_ = (
        ("plane", ctypes.c_void_p),
        ("scaling", ctypes.c_int),
        ("place", ctypes.c_int * 2),
        ("begin", ctypes.c_uint * 2),
        ("size", ctypes.c_uint * 2),
        ("blitter", ctypes.c_int),
        ("flags", ctypes.c_uint64),
        ("transparent", ctypes.c_uint32),
        ("offset", ctypes.c_uint * 2),
    )


class Notcurses:
    """A screen of its own, drawn to a file.

    Attributes:
        version: Of the library.
    """

    def __init__(self, columns: int, rows: int, output: str = os.devnull) -> None:
        """Load the library, and begin; OSError where there is none.

        Args:
            columns: Width [cells].
            rows: Height [cells].
            output: The file that it takes for the terminal.
        """
        built = Path(sys.prefix, "lib", LIBRARY)
        self._library = ctypes.CDLL(str(built) if built.exists() else LIBRARY)
        self.version = self._returns(ctypes.c_char_p, "notcurses_version")().decode()
        # What it believes of a terminal that is no terminal.
        os.environ |= {"COLUMNS": str(columns), "LINES": str(rows)}
        file = ctypes.CDLL(None).fopen
        file.restype = ctypes.c_void_p
        options = _Options(loglevel=_SILENT, flags=_ALONE)
        begin = self._returns(ctypes.c_void_p, "notcurses_core_init")
        terminal = ctypes.c_void_p(file(output.encode(), b"w"))
        self._screen = ctypes.c_void_p(begin(ctypes.byref(options), terminal))
        if not self._screen:
            text = "notcurses does not begin"
            raise OSError(text)
        plane = self._returns(ctypes.c_void_p, "notcurses_stdplane")(self._screen)
        self._plane = ctypes.c_void_p(plane)
        self._visual = _VisualOptions(plane=plane, size=(2 * rows, columns), blitter=_HALF_BLOCKS)
        self._stride = 4 * columns
        counts = self._returns(ctypes.POINTER(ctypes.c_uint64), "notcurses_stats_alloc")
        self._counts = counts(self._screen)
        self._written = 0

    def draw(self, pixels: bytes) -> int:
        """Show a frame, shape (2 * rows, columns, 4); the bytes that it wrote."""
        library, plane = self._library, self._plane
        failed = library.ncblit_rgba(pixels, self._stride, ctypes.byref(self._visual)) < 0
        if failed or library.ncpile_render(plane) or library.ncpile_rasterize(plane):
            text = "notcurses does not draw"
            raise OSError(text)
        library.notcurses_stats(self._screen, self._counts)
        before, self._written = self._written, self._counts[_RASTER_BYTES]
        return self._written - before

    def _returns(self, kind: Any, name: str) -> Callable[..., Any]:
        function = self._library[name]
        function.restype = kind
        return function
