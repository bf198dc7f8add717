"""What the keys of a replay do, and what its rows say; it needs no terminal."""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Callable
from typing import Final

import numpy as np

from rune_tui.compositor.cells import Cells
from rune_tui.controls.keyboard import name_of_key
from rune_tui.replay import screen, timeline
from rune_tui.replay.drawing import FrameCheck
from rune_tui.replay.player import Knowledge, Player
from rune_tui.replay.source import Overview, ReplayFrame
from rune_tui.widgets.listeners import Listeners

SECOND: Final = 1_000_000_000
_TIME: Final = re.compile(r"(\d{1,9}:){0,2}\d{1,9}(\.\d{0,9})?", re.ASCII)
_JUMP_S: Final = 5.0
_LONG_JUMP_S: Final = 60.0
_NOTICE_S: Final = 3.0
HELP: Final = (
    "Space play  arrows 5 s  , . frame  + - rate  R reverse  [ ] marks  :1:30 go to  "
    "home end  L loop  Q quit"
)


class Desk:
    """A player with its keys.

    Attributes:
        player: Plays the recording.
        overview: What happened in it.
        ended: Whether the person ends the replay.
    """

    def __init__(self, player: Player, clock: Callable[[], float]) -> None:
        """Prepare.

        Args:
            player: Plays the recording.
            clock: Monotonic time [s].
        """
        self.player = player
        self.overview = Overview()
        self.ended = False
        self._clock = clock
        self._entry: str | None = None
        self._notice, self._noticed = HELP, -math.inf
        self._bound: tuple[object, frozenset[str]] = None, frozenset()
        self._keys: dict[str, Callable[[], None]] = {
            "space": self._play,
            "left": lambda: self.go(-_JUMP_S),
            "right": lambda: self.go(_JUMP_S),
            "shift+left": lambda: self.go(-_LONG_JUMP_S),
            "shift+right": lambda: self.go(_LONG_JUMP_S),
            "home": lambda: self._seek(player.source.start),
            "end": lambda: self._seek(player.source.end),
            ",": lambda: self._step(-1),
            ".": lambda: self._step(1),
            "+": lambda: player.faster(1),
            "=": lambda: player.faster(1),
            "-": lambda: player.faster(-1),
            "r": player.turn,
            "l": self._loop,
            "[": lambda: self._mark(-1),
            "]": lambda: self._mark(1),
            "?": lambda: self.say(HELP),
            "f1": lambda: self.say(HELP),
            "q": self._quit,
            "ctrl+c": self._quit,
        }

    def key(self, key: str, character: str | None) -> None:
        """Handle a key by the terminal's names of it."""
        name = name_of_key(key, character)
        if self._entry is not None:
            self._type(name, self._entry)
        elif name == ":" or name.isdecimal():
            self._entry = "" if name == ":" else name
        elif name in self._keys:
            self._keys[name]()
        elif self.player.source.press(name, self.player.position):
            self.player.seek(self.player.position)
        elif name in self._driving():
            self.say(f"{name} does nothing: this is a recording")
        else:
            self.say(HELP)

    def click(self, column: int, row: int, columns: int, rows: int) -> None:
        """Handle a click on a cell of a screen of some size."""
        source = self.player.source
        if row >= rows - screen.BOTTOM:
            self._seek(timeline.stamp_of(column, source.start, source.end, columns))

    def go(self, seconds: float) -> None:
        """Go on or back by a time of the recording [s]."""
        self._seek(self.player.position + round(seconds * SECOND))

    def say(self, text: str) -> None:
        """Show a sentence for some seconds."""
        self._notice, self._noticed = text, self._clock()

    def words(self, columns: int) -> tuple[str, str, str]:
        """The first row, and the two of the timeline, at a width."""
        source, position = self.player.source, self.player.position
        line = columns, source.start, source.end, position
        marks = timeline.marks_row(*line, self.overview)
        return self._head(columns), marks, timeline.pointer_row(*line, self._time_forms())

    def cells(self, columns: int, rows: int) -> Cells:
        """The whole screen at a size."""
        head, *line = self.words(columns)
        return screen.framed(self.player.drawer.cells, columns, rows, head, line)

    def fit(self, columns: int, rows: int) -> None:
        """Draw at the size of the console then if there is room, else as large as there is."""
        room = screen.room(columns, rows)
        frame = self.player.frame
        recorded = frame.size if frame is not None else None
        fits = recorded is not None and recorded[0] <= room[0] and recorded[1] <= room[1]
        self.player.resize(None if fits else room)

    def _head(self, columns: int) -> str:
        player = self.player
        rate = timeline.rate_text(player.rate, player.reached)
        way = "back" if player.backwards else "plays"
        does = way if player.playing else "paused"
        said = f" RECORDING {moment_text(player.position)}  {does} {rate}"
        if player.loop:
            said += "  loop"
        if player.knows is not Knowledge.ALL:
            said += f"  filling trails and plots ({player.ready:.0%})"
        elif (check := self._checked()).value:
            said += f"  {check.value}"
        if self._entry is not None:
            said += f"  go to :{self._entry}_"
        elif self._clock() - self._noticed < _NOTICE_S:
            said += f"  · {self._notice}"
        elif player.source.faults:
            said += f"  · {player.source.faults[-1]}"
        elif columns - len(said) > len(player.source.title) + 2:
            said += f"{player.source.title:>{columns - len(said) - 1}}"
        return said

    def _checked(self) -> FrameCheck:
        """Whether the frame is that of then; not looked at while it plays."""
        check = self.player.drawer.check
        looked = check is FrameCheck.OTHER_SIZE or not self.player.playing
        return check if looked else FrameCheck.UNKNOWN

    def _time_forms(self) -> tuple[str, str]:
        source = self.player.source
        here = timeline.clock_text((self.player.position - source.start) / SECOND)
        whole = timeline.clock_text((source.end - source.start) / SECOND)
        return f" RECORDING {here} / {whole} ", f" {here} "

    def _play(self) -> None:
        player = self.player
        if not player.playing and not player.backwards and player.position >= player.source.end:
            player.seek(player.source.start)
        player.playing = not player.playing

    def _loop(self) -> None:
        self.player.loop = not self.player.loop

    def _quit(self) -> None:
        self.ended = True

    def _step(self, count: int) -> None:
        if self.player.step(count) is None:
            self.say(f"this is the {'last' if count > 0 else 'first'} frame")

    def _seek(self, stamp: int) -> None:
        self.player.seek(stamp)

    def _mark(self, way: int) -> None:
        """Go to the next event, or the one before (-1)."""
        here = self.player.position
        stamps = [event.stamp for event in self.overview.events]
        found = (
            min((each for each in stamps if each > here), default=None)
            if way > 0
            else max((each for each in stamps if each < here), default=None)
        )
        if found is None:
            self.say(f"there is no mark {'after' if way > 0 else 'before'} this time")
            return
        self._seek(found)
        event = next(each for each in self.overview.events if each.stamp == found)
        self.say(event.text or event.kind.name.lower())

    def _type(self, name: str, entry: str) -> None:
        """A key while a time is entered."""
        if name in {"escape", "q", "ctrl+c"}:
            self._entry = None
        elif name == "backspace":
            self._entry = entry[:-1]
        elif name == "enter":
            self._entry = None
            stamp = entered(entry, self.player.source.start)
            if stamp is None:
                self.say(f"{entry} is no time; 90, 1:30 and 1:02:30 are")
            else:
                self._seek(stamp)
        elif name in {":", "."} or name.isdecimal():
            self._entry = entry + name

    def _driving(self) -> frozenset[str]:
        """The inputs that the shown layout binds."""
        frame: ReplayFrame | None = self.player.frame
        if frame is None:
            return frozenset()
        if self._bound[0] is not frame.layout:
            self._bound = frame.layout, frozenset(Listeners(frame.layout).names)
        return self._bound[1]


def moment_text(stamp: int) -> str:
    """A time [ns since 1970] as date and time of day here."""
    moment = datetime.datetime.fromtimestamp(stamp / SECOND, datetime.UTC).astimezone()
    return f"{moment:%Y-%m-%d %H:%M:%S}"


def entered(text: str, start: int) -> int | None:
    """The time that a person means by seconds, minutes:seconds or hours:minutes:seconds.

    Only the first part may be 60 or more, and only the last one may have a fraction.

    Args:
        text: The letters.
        start: Begin of the recording [ns].

    Returns:
        The time [ns]; None: it is none.
    """
    if not _TIME.fullmatch(text.strip()):
        return None
    first, *rest = (float(each) for each in text.split(":"))
    if any(part >= 60.0 for part in rest):
        return None
    seconds = first
    for part in rest:
        seconds = 60.0 * seconds + part
    return start + round(min(seconds, 1e9) * SECOND)


def no_urgencies(columns: int, rows: int) -> np.ndarray[tuple[int, int], np.dtype[np.uint8]]:
    """Urgency of each cell of a screen, which are equal."""
    return np.zeros((rows, columns), np.uint8)
