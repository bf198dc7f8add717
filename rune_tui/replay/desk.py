"""What the keys of a replay do, and what its rows say; it needs no terminal."""

from __future__ import annotations

import datetime
import enum
import math
import re
from collections.abc import Callable
from typing import Final, Protocol

import numpy as np

from hub.command_line import login_name
from hub.values import dataclass
from rune_tui.compositor.cells import Cells
from rune_tui.controls.keyboard import name_of_key
from rune_tui.errors import LogError
from rune_tui.replay import screen, timeline
from rune_tui.replay.drawing import FrameCheck
from rune_tui.replay.player import Knowledge, Player
from rune_tui.replay.review_keys import SHORT, TASKS, ReviewTask, help_lines
from rune_tui.replay.review_notes import LONGEST, ReviewNotes
from rune_tui.replay.source import Overview, ReplayFrame, with_notes
from rune_tui.widgets.listeners import Listeners

SECOND: Final = 1_000_000_000
_TIME: Final = re.compile(r"(\d{1,9}:){0,2}\d{1,9}(\.\d{0,9})?", re.ASCII)
_JUMPS: Final = (ReviewTask.JUMP, ReviewTask.LONG_JUMP, ReviewTask.ENDS)
"""Tasks that only change where the next frame is."""
_JUMP_S: Final = 5.0
_LONG_JUMP_S: Final = 60.0
_NOTICE_S: Final = 3.0


class TypedKind(enum.Enum):
    """What is typed; the value leads it in the first row."""

    TIME = "go to :"
    NOTE = "note: "


@dataclass(slots=True)
class TypedText:
    """Letters that are typed.

    Attributes:
        kind: What they are.
        text: The letters.
        stamp: The time that a note is about [ns].
    """

    kind: TypedKind
    text: str = ""
    stamp: int = 0


class Clips(Protocol):
    """Writes clips while the recording is shown."""

    @property
    def progress(self) -> str:
        """What it writes, and how far it is; empty: nothing."""

    def result(self) -> str:
        """What became of the last clip, in one sentence; empty: it was asked for, or none is."""

    def write(self, begin: int, end: int) -> str:
        """Begin to write a clip between two times after the begin [ns]; returns why not."""


class Desk:
    """A player with its keys.

    Attributes:
        player: Plays the recording.
        overview: What happened in it.
        ended: Whether the person ends the replay.
        helps: Whether the page of the keys is shown.
    """

    def __init__(
        self,
        player: Player,
        clock: Callable[[], float],
        notes: ReviewNotes | None = None,
        clips: Clips | None = None,
    ) -> None:
        """Prepare.

        Args:
            player: Plays the recording.
            clock: Monotonic time [s].
            notes: Keeps what a person notes; None: nothing is kept.
            clips: Writes clips; None: none are written.
        """
        self.player = player
        self.overview = Overview()
        self.ended = False
        self._clock = clock
        self._notes, self._clips = notes, clips
        self._entry: TypedText | None = None
        self._clip_begin: int | None = None
        self._leaving = False
        self._goal: int | None = None
        self.helps = False
        self._notice, self._noticed = SHORT, -math.inf
        self._bound: tuple[object, frozenset[str]] = None, frozenset()
        self._tasks: dict[ReviewTask, Callable[[int], None]] = {
            ReviewTask.PLAY: lambda _: self._play(),
            ReviewTask.JUMP: lambda place: self.go((2 * place - 1) * _JUMP_S),
            ReviewTask.LONG_JUMP: lambda place: self.go((2 * place - 1) * _LONG_JUMP_S),
            ReviewTask.STEP: lambda place: self._step(2 * place - 1),
            ReviewTask.RATE: lambda place: player.faster(2 * place - 1),
            ReviewTask.FASTER: lambda _: player.faster(1),
            ReviewTask.TURN: lambda _: player.turn(),
            ReviewTask.EVENT: lambda place: self._mark(2 * place - 1),
            ReviewTask.TIME: lambda _: self._ask(TypedText(TypedKind.TIME)),
            ReviewTask.ENDS: lambda place: self._seek(player.source.end if place else 0),
            ReviewTask.LOOP: lambda _: self._loop(),
            ReviewTask.NOTE: lambda _: self._begin_note(),
            ReviewTask.CLIP: lambda _: self._clip(),
            ReviewTask.DROP: lambda _: self._drop(),
            ReviewTask.HELP: lambda _: self._help(),
            ReviewTask.QUIT: lambda _: self._quit(),
        }

    def key(self, key: str, character: str | None) -> None:
        """Handle a key by the terminal's names of it."""
        name = name_of_key(key, character)
        task, place = TASKS.get(name, (None, 0))
        if task not in _JUMPS:
            self.settle()
        self._leaving = self._leaving and task is ReviewTask.QUIT
        if self._entry is not None:
            self._type(name, character, self._entry)
        elif self.helps and task is not ReviewTask.QUIT:
            self.helps = False
        elif name.isdecimal():
            self._ask(TypedText(TypedKind.TIME, name))
        elif task is not None:
            self._tasks[task](place)
        elif self.player.source.press(name, self.player.position):
            self.player.seek(self.player.position)
        elif name in self._driving():
            self.say(f"{name} does nothing: this is a recording")
        else:
            self.say(SHORT)

    def click(self, column: int, row: int, columns: int, rows: int) -> None:
        """Handle a click on a cell of a screen of some size."""
        source = self.player.source
        if row >= rows - screen.BOTTOM:
            self._seek(timeline.stamp_of(column, source.start, source.end, columns))

    def go(self, seconds: float) -> None:
        """Go on or back by a time of the recording [s]."""
        here = self.player.position if self._goal is None else self._goal
        self._seek(here + round(seconds * SECOND))

    def settle(self) -> None:
        """Jump to where keys and clicks lead; once, however many there were."""
        goal, self._goal = self._goal, None
        if goal is not None:
            self.player.seek(goal)

    def say(self, text: str) -> None:
        """Show a sentence for some seconds."""
        self._notice, self._noticed = text, self._clock()

    def words(self, columns: int) -> tuple[str, str, str]:
        """The first row, and the two of the timeline, at a width."""
        self.settle()
        source, position = self.player.source, self.player.position
        if self._clips is not None and (result := self._clips.result()):
            self.say(result)
        line = columns, source.start, source.end, position
        marks = timeline.marks_row(*line, self.overview)
        return self._head(columns), marks, timeline.pointer_row(*line, self._time_forms())

    def cells(self, columns: int, rows: int) -> Cells:
        """The whole screen at a size."""
        head, *line = self.words(columns)
        cells = screen.framed(self.player.drawer.cells, columns, rows, head, line)
        if self.helps:
            screen.write_page(cells, list(help_lines()))
        return cells

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
        noticed = self._clock() - self._noticed < _NOTICE_S
        if self._entry is None and not noticed:  # else a narrow terminal needs the room
            said += self._exactness()
        if self._clip_begin is not None:
            begin = timeline.clock_text((self._clip_begin - player.source.start) / SECOND)
            said += f"  clip from {begin}, X ends it"
        if self._clips is not None and (progress := self._clips.progress):
            said += f"  {progress}"
        if self._entry is not None:
            said += f"  {self._entry.kind.value}{self._entry.text}_"
        elif noticed:
            said += f"  · {self._notice}"
        elif player.source.faults:
            said += f"  · {player.source.faults[-1]}"
        elif columns - len(said) > len(player.source.title) + 2:
            said += f"{player.source.title:>{columns - len(said) - 1}}"
        return said

    def _exactness(self) -> str:
        """Whether the frame is exact, or how far the replay is on the way there."""
        if self.player.knows is not Knowledge.ALL:
            return f"  filling trails and plots ({self.player.ready:.0%})"
        check = self._checked()
        return f"  {check.value}" if check.value else ""

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
        """End; a clip that is not complete needs a second press."""
        writes = self._clips.progress if self._clips is not None else ""
        self.ended = self._leaving or not writes
        self._leaving = True
        if not self.ended:
            self.say("a clip is still written; press again to drop it and end")

    def _step(self, count: int) -> None:
        if self.player.step(count) is None:
            self.say(f"this is the {'last' if count > 0 else 'first'} frame")

    def _seek(self, stamp: int) -> None:
        source = self.player.source
        self._goal = min(max(stamp, source.start), source.end)

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

    def _ask(self, entry: TypedText) -> None:
        self._entry = entry

    def _type(self, name: str, character: str | None, entry: TypedText) -> None:
        """A key while something is typed."""
        is_time = entry.kind is TypedKind.TIME
        if name in ("escape", "ctrl+c") or (name == "q" and is_time):
            self._entry = None
        elif name == "backspace":
            entry.text = entry.text[:-1]
        elif name == "enter":
            self._entry = None
            if is_time:
                self._go_to(entry.text)
            else:
                self._keep_note(entry)
        elif is_time and (name in (":", ".") or name.isdecimal()):
            entry.text += name
        elif not is_time and character is not None and character.isprintable():
            entry.text = (entry.text + character)[:LONGEST]

    def _go_to(self, text: str) -> None:
        stamp = entered(text, self.player.source.start)
        if stamp is None:
            self.say(f"{text} is no time; 90, 1:30 and 1:02:30 are")
        else:
            self._seek(stamp)

    def _begin_note(self) -> None:
        self.player.playing = False
        self._ask(TypedText(TypedKind.NOTE, stamp=self.player.position))

    def _keep_note(self, entry: TypedText) -> None:
        if self._notes is None:
            self.say("notes are not kept here")
            return
        try:
            event = self._notes.add(entry.stamp, entry.text, login_name())
        except LogError as error:
            self.say(str(error))
            return
        self.overview = with_notes(self.overview, [event])
        self.say(f"noted in {self._notes.path.name}")

    def _clip(self) -> None:
        """Begin a clip, or write the one that was begun."""
        begin, here = self._clip_begin, self.player.position
        if self._clips is None:
            self.say("clips are not written here")
        elif begin is None:
            self._clip_begin = here
        elif begin == here:
            self.say(
                "a clip needs an end at another time; go there and press X, or drop it with Esc"
            )
        else:
            start = self.player.source.start
            why = self._clips.write(min(begin, here) - start, max(begin, here) - start)
            if why:
                self.say(why)
            else:
                self._clip_begin = None

    def _drop(self) -> None:
        self._clip_begin = None

    def _help(self) -> None:
        self.helps = True

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
