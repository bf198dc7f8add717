"""Motion to photon: from an input to the picture on screen that shows what it did."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError
from rune_study.statistics.arrays import Floats, floats


def motion_to_photon(
    inputs: npt.ArrayLike,
    answered: npt.ArrayLike,
    captured: npt.ArrayLike,
    shown: npt.ArrayLike,
) -> Floats:
    """Time from each input to the first frame whose picture was taken after the world answered [s].

    A frame whose picture was taken before that does not count, even if it is shown later.

    Args:
        inputs: When the operator did something [s], shape (n,).
        answered: When the world answered to it [s], shape (n,); NaN: it did not.
        captured: When the picture of each frame was taken [s], shape (frames,).
        shown: When the frame was on screen [s], shape (frames,).

    Returns:
        Shape (n,); NaN where no such frame came.

    Raises:
        DataError: Lengths differ.
    """
    begins, answers = floats(inputs, "inputs"), floats(answered, "answered")
    taken, visible = floats(captured, "captured"), floats(shown, "shown")
    if len(begins) != len(answers) or len(taken) != len(visible):
        text = "each input needs the time of its answer, and each frame two times"
        raise DataError(text)
    order = np.argsort(taken, kind="stable")
    taken, visible = taken[order], visible[order]
    result = np.full(begins.shape, np.nan)
    for place, (begin, answer) in enumerate(zip(begins, answers, strict=True)):
        first = np.searchsorted(taken, answer) if np.isfinite(answer) else len(taken)
        later = visible[first:]
        later = later[later >= begin]
        if later.size:
            result[place] = later.min() - begin
    return result
