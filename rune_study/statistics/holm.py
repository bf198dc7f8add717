"""Several tests at once."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError
from rune_study.statistics.arrays import Floats, floats


def holm(p_values: npt.ArrayLike) -> Floats:
    """p-values that hold for all tests together (S. Holm, Scand. J. Statist. 6, 1979).

    The smallest of m counts m times, the next m - 1 times, and none less than one before it.

    Args:
        p_values: One for each test. NaN is a test that could not be made; it stays NaN and is not
            counted, as in R's `p.adjust`.

    Returns:
        Adjusted p-values, at most 1, in the same order.

    Raises:
        DataError: A p-value is not between 0 and 1.
    """
    given = floats(p_values, "p-values")
    made = np.flatnonzero(~np.isnan(given))
    if ((given[made] < 0.0) | (given[made] > 1.0)).any():
        text = "a p-value is not between 0 and 1"
        raise DataError(text)
    order = made[np.argsort(given[made], kind="stable")]
    adjusted = np.full(given.shape, np.nan)
    raised = given[order] * np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(raised), 1.0)
    return adjusted
