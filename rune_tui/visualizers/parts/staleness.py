"""The drawing of old data: dimmed at one second, hatched and marked with its age at three."""

from __future__ import annotations

import enum
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.ipc.definition import MessageDefinition
from rune_tui.model.robot_state import Picture, Received
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing

MENTION_AFTER_S = 0.25
ALARM_AFTER_S = 0.5
"""Largest age of pictures to drive by [s]: beyond it, people move and wait, and turn too late
(Chen, Haas and Barnes 2007).
"""
_ON_ITS_WAY_S = 0.15
"""Usual age of a picture on its arrival, with room for a busy machine [s]."""
DIM_AFTER_S = 1.0
HATCH_AFTER_S = 3.0

_HATCH_PERIOD = 6
_HATCH_WIDTH = 2


class Staleness(enum.IntEnum):
    """The drawing of data by age.

    Attributes:
        FRESH: Shown as it is.
        OLD: Dimmed.
        STALE: Hatched, marked with a word and its age.
    """

    FRESH = 0
    OLD = 1
    STALE = 2


def usual_age(picture: Picture) -> float:
    """Age of a picture at which the next should have arrived [s]."""
    return picture.interval_s + _ON_ITS_WAY_S


def pause_of(definition: MessageDefinition[Any]) -> float:
    """Normal delay of the next message [s].

    For messages of at most 1 Hz, which would always be old without it; else 0.
    """
    return 1.0 / definition.rate_hz if 0.0 < definition.rate_hz <= 1.0 / DIM_AFTER_S else 0.0


def staleness(age: float, pause: float = 0.0) -> Staleness:
    """The staleness of data of an age [s], with a usual pause between messages [s]."""
    if age > HATCH_AFTER_S + pause:
        return Staleness.STALE
    return Staleness.OLD if age > DIM_AFTER_S + pause else Staleness.FRESH


def age_text(age: float) -> str:
    """An age [s] in words: "4.2 s", "37 s", "3 min", "2 h"."""
    # Rounded down: the text is never more than the age.
    if age < 10.0:
        return f"{int(age * 10.0) / 10.0:.1f} s"
    if age < 120.0:
        return f"{int(age)} s"
    return f"{int(age / 60.0)} min" if age < 7200.0 else f"{int(age / 3600.0)} h"


def age_look(received: Received[Any], now: float, pause: float = 0.0) -> tuple[Staleness, str]:
    """The drawing of an age by `fade_by_age` and `mark_age`; equal values, equal drawings."""
    age = received.age(now)
    step = staleness(age, pause)
    return step, age_text(age) if step is Staleness.STALE else ""


def fade_by_age(canvas: Canvas, age: float, pause: float = 0.0) -> None:
    """Fade a drawing by its age [s]; clear pixels stay clear."""
    step = staleness(age, pause)
    if step is Staleness.FRESH:
        return
    for colours in (canvas.pixels, canvas.ink):
        channels = colours[..., :3].astype(np.uint16)
        grey = channels.sum(axis=2, keepdims=True, dtype=np.uint16) // 3
        colours[..., :3] = (3 * channels + 2 * grey) // 10
    if step is Staleness.STALE:
        row, column = np.indices(canvas.pixels.shape[:2])
        stripes = (row + column) % _HATCH_PERIOD < _HATCH_WIDTH
        canvas.pixels[stripes, :3] //= 3


def draw_age(canvas: Canvas, age: float, theme: Theme, pause: float = 0.0) -> None:
    """Fade a drawing by its age [s], and write the age on it if stale."""
    fade_by_age(canvas, age, pause)
    mark_age(canvas, age, theme, pause)


def mark_age(canvas: Canvas, age: float, theme: Theme, pause: float = 0.0) -> None:
    """Write "STALE 4.2 s" where no words are, if data of this age [s] is stale.

    That is the middle of the first row, else the end of a row; a shorter form, if room is short.
    Words are never covered: where they take all room, fading alone marks the age.
    """
    if staleness(age, pause) is not Staleness.STALE or not canvas.rows:
        return
    forms = (f" STALE {age_text(age)} ", f" STALE {age_text(age)}", f"!{age_text(age)}", "!")
    found = (
        (form, place) for form in forms if (place := _free_place(canvas, len(form))) is not None
    )
    free = next(found, None)
    if free is None:
        return
    form, (row, column) = free
    with drawing(canvas) as pen:
        pen.rectangle(column, 2 * row, column + len(form), 2 * row + 2, theme.panel)
    canvas.text(column, row, form, theme.warning)


def _free_place(canvas: Canvas, length: int) -> tuple[int, int] | None:
    """Row and column of a run of cells without words; the middle of the first row, if it is one."""
    last = canvas.width - length
    if last < 0:
        return None
    written = (canvas.glyphs != 0) & (canvas.glyphs != ord(" "))
    # A run has a free cell on each side of it; beyond the edges all is free.
    words = np.pad(written, ((0, 0), (1, 1)))
    runs = np.lib.stride_tricks.sliding_window_view(words, length + 2, axis=1)
    taken: npt.NDArray[np.bool_] = np.any(runs, axis=2)
    if not taken[0, last // 2]:
        return 0, last // 2
    free = np.argwhere(~taken[:, ::-1])
    return (int(free[0, 0]), last - int(free[0, 1])) if len(free) else None
