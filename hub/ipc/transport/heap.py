"""Keeps the C heap from returning memory after each large message and asking for it again."""

from __future__ import annotations

import ctypes
import functools
import os
import sys
from collections.abc import Callable
from typing import cast

_M_TRIM_THRESHOLD, _M_TOP_PAD, _M_ARENA_MAX = -1, -2, -8
_TRIM_BYTES = 512 << 20
_PAD_BYTES = 16 << 20
_ARENAS = 2
_KEPT_BYTES = 1 << 20
_SET_ALREADY = ("MALLOC_TRIM_THRESHOLD_", "MALLOC_TOP_PAD_", "MALLOC_ARENA_MAX", "GLIBC_TUNABLES")


@functools.cache
def keep_heap() -> bool:
    """Make glibc's allocator keep its memory; whether that was possible.

    A picture's buffer lies at the top of the heap. By default, glibc returns it to the system, and
    each page of it faults in again for the next picture. That costs more than a copy of the
    picture. Environment variables of the user override this.
    """
    if sys.platform != "linux" or any(name in os.environ for name in _SET_ALREADY):
        return False
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):  # another C library
        return False
    settings = ((_M_TRIM_THRESHOLD, _TRIM_BYTES), (_M_TOP_PAD, _PAD_BYTES), (_M_ARENA_MAX, _ARENAS))
    return all(mallopt(option, value) == 1 for option, value in settings)


@functools.cache
def _trimmer() -> Callable[[int], int] | None:
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (OSError, AttributeError):
        return None
    return cast("Callable[[int], int]", trim)


def give_back() -> None:
    """Return unused memory to the system, for example after many connections."""
    trim = _trimmer()
    if trim is not None:
        trim(_KEPT_BYTES)
