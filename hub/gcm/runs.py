"""Runs of equal numbers: their ends, and their lengths below a limit."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Number = TypeVar("Number", bound=np.generic)


def run_ends(flat: npt.NDArray[Any]) -> npt.NDArray[np.intp]:
    """Index of the last number of each run, shape (runs,); `flat` has at least one number."""
    return np.append(np.flatnonzero(flat[1:] != flat[:-1]), flat.size - 1)


def cut_runs(
    flat: npt.NDArray[Number], ends: npt.NDArray[np.intp], longest: int
) -> tuple[npt.NDArray[np.intp], npt.NDArray[Number]]:
    """Lengths and numbers of the runs, shape (pieces,) each.

    Args:
        flat: The numbers.
        ends: Their `run_ends`.
        longest: A longer run is cut into pieces of this length and one of the rest.
    """
    lengths, numbers = np.diff(ends, prepend=-1), flat[ends]
    if lengths.max() > longest:
        pieces = -(-lengths // longest)
        last = np.cumsum(pieces) - 1
        rest = lengths - (pieces - 1) * longest
        numbers = np.repeat(numbers, pieces)
        lengths = np.full(len(numbers), longest)
        lengths[last] = rest
    return lengths, numbers
