"""The keys of a replay: what each does, for the help on the screen and the page about it."""

from __future__ import annotations

import enum
from collections.abc import Iterator
from typing import Final

from hub.values import dataclass


@dataclass(frozen=True, slots=True)
class ReviewKey:
    """A key, or several with one task.

    Attributes:
        written: How people name it.
        does: What it does.
        names: The names of keys of this task, in its order: back or less comes first.
    """

    written: str
    does: str
    names: tuple[str, ...]


class ReviewTask(enum.Enum):
    """What a key of a replay does."""

    PLAY = ReviewKey("Space", "plays, or pauses", ("space",))
    JUMP = ReviewKey("Left, Right", "5 s back or on; with Shift a minute", ("left", "right"))
    LONG_JUMP = ReviewKey("", "", ("shift+left", "shift+right"))
    STEP = ReviewKey(", .", "one frame back or on", (",", "."))
    RATE = ReviewKey("- +", "slower or faster: x0.1 to x100", ("-", "+"))
    FASTER = ReviewKey("", "", ("=",))
    TURN = ReviewKey("R", "the other way", ("r",))
    EVENT = ReviewKey("[ ]", "to the mark before or after", ("[", "]"))
    TIME = ReviewKey("digits or :, Enter", "to a time after the begin: 90, 1:30, 1:02:30", (":",))
    ENDS = ReviewKey("Home, End", "to the first or the last frame", ("home", "end"))
    LOOP = ReviewKey("L", "begins again at the end", ("l",))
    NOTE = ReviewKey("M", "notes something at this time; Enter keeps it", ("m",))
    CLIP = ReviewKey("X", "begins a clip here; again ends it and writes a video", ("x",))
    DROP = ReviewKey("Esc", "drops the begin of a clip, or what is typed", ("escape",))
    HELP = ReviewKey("?, F1", "these keys", ("?", "f1"))
    QUIT = ReviewKey("Q", "ends", ("q", "ctrl+c"))


TASKS: Final = {
    name: (task, place) for task in ReviewTask for place, name in enumerate(task.value.names)
}
"""The task of each key, and its place among the keys of this task."""
SHORT: Final = (
    "Space plays  Left Right 5 s  , . frame  - + rate  [ ] marks  M note  X clip  ? all keys"
)
"""The most needed keys in one row."""


def help_lines() -> Iterator[str]:
    """All keys, one a line."""
    shown = [task.value for task in ReviewTask if task.value.written]
    width = max(len(key.written) for key in shown)
    return (f"{key.written:<{width}}  {key.does}" for key in shown)
