"""Arrays of values as statistics take them: checked, and without incomplete participants."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


def floats(values: npt.ArrayLike, what: str, dimensions: int = 1) -> Floats:
    """Numbers as an array.

    Args:
        values: Numbers; None and NaN are missing ones.
        what: Their name, for the message of the error.
        dimensions: Number of axes they must have.

    Raises:
        DataError: They are no numbers, or have other axes.
    """
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        text = f"{what}: these are not all numbers"
        raise DataError(text) from None
    if array.ndim != dimensions:
        text = f"{what}: the array has {array.ndim} axes and not {dimensions}"
        raise DataError(text)
    return array


def complete_cases(values: Floats) -> tuple[Floats, tuple[int, ...]]:
    """The rows without a missing value, and the numbers of the others.

    Args:
        values: One row for each participant.

    Raises:
        DataError: A value is infinite.
    """
    if np.isinf(values).any():
        text = "a value is infinite: use ranks or a restricted mean for times that never end"
        raise DataError(text)
    whole = (
        ~np.isnan(values).reshape(len(values), -1).any(axis=1) if len(values) else np.ones(0, bool)
    )
    return values[whole], tuple(np.flatnonzero(~whole).tolist())


def pairs(first: npt.ArrayLike, second: npt.ArrayLike) -> tuple[Floats, tuple[int, ...]]:
    """The complete pairs, shape (pairs, 2), and the numbers of the others.

    Args:
        first: One value for each participant.
        second: The same under another condition.

    Raises:
        DataError: They have different lengths, or a value is infinite.
    """
    a, b = floats(first, "first condition"), floats(second, "second condition")
    if len(a) != len(b):
        text = f"pairs need equally many values, but there are {len(a)} and {len(b)}"
        raise DataError(text)
    return complete_cases(np.column_stack((a, b)))
