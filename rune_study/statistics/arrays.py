"""Arrays of values as statistics take them: checked, and without incomplete participants."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_LARGEST = 1e150


def floats(values: npt.ArrayLike, what: str, dimensions: int | None = 1) -> Floats:
    """Numbers as an array.

    Args:
        values: Numbers; None, NaN and masked ones are missing.
        what: Their name, for the message of the error.
        dimensions: Number of axes they must have; None: any.

    Raises:
        DataError: They are no numbers, or have other axes.
    """
    try:
        array = np.ma.filled(np.ma.asarray(values, np.float64), np.nan)
    except (TypeError, ValueError):
        text = f"{what}: these are not all numbers"
        raise DataError(text) from None
    if dimensions is not None and array.ndim != dimensions:
        text = f"{what}: the array has {array.ndim} axes and not {dimensions}"
        raise DataError(text)
    return array


def complete_cases(values: Floats) -> tuple[Floats, tuple[int, ...]]:
    """The rows without a missing value, and the numbers of the others.

    Args:
        values: One row for each participant.

    Raises:
        DataError: A value is infinite, or too large to be squared.
    """
    if np.isinf(values).any():
        text = "a value is infinite: use ranks or a restricted mean for times that never end"
        raise DataError(text)
    if (np.abs(values) > _LARGEST).any():
        text = f"a value is beyond {_LARGEST:g}, where squares are no numbers any more"
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
