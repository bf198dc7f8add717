"""What the recorder says of marks and of ends: whether the disk has them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Final

from hub.errors import RecordingError
from hub.gcm.recording import RECORD_MARK, RecordMark
from hub.recording.live.series import RecordingSeries, SeriesState

_MARK_S: Final = 2.0
"""Longest wait for the disk to take a mark, of all series together [s]."""


def said_of_mark(series: Sequence[RecordingSeries], mark: RecordMark) -> str:
    """The result of a mark; waits for the disk.

    Args:
        series: The series that were given it; none: the settings leave it out.
        mark: The mark.

    Raises:
        RecordingError: It is in none of them.
    """
    until = time.monotonic() + _MARK_S
    without = [each for each in series if not each.keeps(max(0.0, until - time.monotonic()))]
    if not series:
        text = f"no mark is kept: [recording] of the robot file leaves {RECORD_MARK.name} out"
        raise RecordingError(text)
    slow = f"the disk has not taken it for {_MARK_S:g} s"
    why = "; ".join(each.state.fault or slow for each in without)
    if len(without) == len(series):
        text = f"mark {mark.number} is not kept: {why}"
        raise RecordingError(text)
    text = f"mark {mark.number} is kept" + (f": {mark.text}" if mark.text else "")
    return f"{text}; only in a part of the files: {why}" if without else text


def said_of_end(state: SeriesState, lost: int) -> str:
    """The result of a recording that is closed.

    Args:
        state: Its state.
        lost: Number of messages that it lacks.

    Raises:
        RecordingError: It lacks messages, or its end.
    """
    text = f"{state.messages} messages ({state.bytes / 1e6:.1f} MB) are in {state.path}"
    text += f" and {state.files - 1} files before it" if state.files > 1 else ""
    if lost or state.fault:
        why = f": {state.fault}" if state.fault else ""
        text = f"the recording is ended, and lacks {lost} messages{why}; {text}"
        raise RecordingError(text)
    return text


def said_of_split(state: SeriesState) -> str:
    """The result of an order to go on in another file.

    Raises:
        RecordingError: The recording does not.
    """
    if state.fault:
        text = f"it does not go on: {state.fault}"
        raise RecordingError(text)
    return f"goes on in {state.path}"
