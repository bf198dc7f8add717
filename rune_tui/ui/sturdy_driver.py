"""Textual's driver for Unix terminals, changed so that no input can end the console.

| input | Textual's own driver |
| --- | --- |
| bytes that are not UTF-8, or escape sequences with unusable numbers | ends the console |
| end of the terminal | reads forever |
| answers of a slow terminal after the end | leaves them to the shell, which shows them |
| a button's release beyond the upper left corner | loses it |
| a mouse that moves faster than the console handles it | delays all keys |
| a paste without brackets | takes each character for a key |
| a paste whose end is lost | takes all keys for text, forever |
"""

from __future__ import annotations

import codecs
import logging
import os
import re
import selectors
import threading
import time
from collections.abc import Iterable
from itertools import chain
from typing import Final

from textual import events
from textual.message import Message

from rune_tui.controls.typing_speed import TOGETHER_S, PastedKeys, Stroke, TypingSpeed
from rune_tui.terminal.input_stream import (
    HOLD_S,
    BrokenSequence,
    CursorReport,
    InputPart,
    InputStream,
    KeyboardReport,
    KeyMove,
    KeyReport,
    Paste,
)
from rune_tui.ui.driver_reports import FrameAnswered, KeyMoved, KeysDropped, ReleasesReported
from rune_tui.ui.textual_inside import (
    InsideDriver,
    KeyParser,
    is_understood,
    writes_block,
)

_logger = logging.getLogger(__name__)

_MOST_WAITING: Final = 8
"""Number of waiting messages above which moves of the mouse are dropped."""
_MOVES: Final = (events.MouseMove, events.MouseScrollUp, events.MouseScrollDown)
_OUTSIDE: Final = re.compile(r";(-\d+|0)(?=[;Mm])")
"""Columns and rows of the mouse left of the terminal or above it."""
_STALE: Final = re.compile(r"\x1b\[<(3[2-9]|[45]\d|6[0-3]);-?\d+;-?\d+M(?=\x1b\[<\1;-?\d+;-?\d+M)")
"""Reports of a moving mouse before the next report; Textual is slow to read each."""
_UNUSABLE: Final = re.compile(r"\d{7}|\x1b\[(?!.*t\Z)[\d:]*:|\x1b\[(?!.*t\Z)[\d:]*;\d*:")
"""Numbers that Textual misreads, and parts of numbers that end its parser."""
_READ_S: Final = 0.1
"""Longest wait for input before the loop checks the clock [s]."""
_REPORT_RELEASES: Final = "\x1b[=6;2u\x1b[?u"
"""Kitty keyboard protocol: turn on reports of repeats, releases and US keys; ask what is on."""
_LAST_ROW: Final = 3
"""Row of the cursor for the last question; frames ask in another one."""
_LAST_QUESTION: Final = f"\x1b[=0u\x1b[?1004l\x1b[{_LAST_ROW};1H\x1b[6n"
"""Ends reports of keys and of the focus, and asks where the cursor is."""
_LAST_ANSWER_S: Final = 1.5
"""Longest wait for the last answer; well below `LEAVE_S`, which ends by force [s]."""
_MOST_DOWN: Final = 64
"""Most keys that are down together; one more means that the first one's release was lost."""
_TYPES_TEXT: Final = ("enter", "tab")
"""Keys of text that are not printable."""
_MOST_PASTED: Final = 4096
"""Most characters of a paste without its end that are looked at for stops."""
_Key = tuple[str, str | None, str, str]
"""Textual's name of a key, the character it types, its name on the keypad, its US character."""


def understood(sequence: str) -> bool:
    """Whether Textual understands an escape sequence and its numbers."""
    return not _UNUSABLE.search(sequence) and is_understood(sequence)


class SturdyParser(KeyParser):
    """Moves a mouse beyond the upper left corner to the edge, and reads F3 as F3."""

    def parse_mouse_code(self, code: str) -> Message | None:
        """The event in a report of the mouse."""
        return super().parse_mouse_code(_OUTSIDE.sub(";1", code))

    def meant(self, event: Message) -> Iterable[Message]:
        """The event; a key if Textual misread it as a cursor in the first row."""
        if not isinstance(event, events.CursorPosition):
            return (event,)
        return self.keys_of(f"\x1b[{event.y + 1};{event.x + 1}R")


class SturdyDriver(InsideDriver):
    """Accepts any bytes; a lost terminal ends the console in order.

    Attributes:
        lost: Whether output was dropped because the terminal blocked.
    """

    lost: bool = False
    _down: dict[str, tuple[_Key, ...]]
    """Keys that are down, by the terminal's codes."""
    _speed: TypingSpeed[events.Key]
    _ending: bool = False
    _answers: bool = False
    """Whether the terminal has said where its cursor is."""
    _dropped_move: events.MouseMove | None = None
    """The newest dropped move of the mouse."""

    def start_application_mode(self) -> None:
        """Enter the terminal, and turn on reports of releases."""
        self._down = {}
        self._speed = TypingSpeed()
        self._last_answer = threading.Event()
        super().start_application_mode()
        self.write(_REPORT_RELEASES)

    def write(self, data: str) -> None:
        """Queue output, or drop it if that would block the console."""
        if not self._ending and writes_block(self):
            self.lost = True
        else:
            super().write(data)

    def stop_application_mode(self) -> None:
        """Leave the terminal as it was; no byte of that may be dropped."""
        self._ending = True
        super().stop_application_mode()
        self._ending = False

    def disable_input(self) -> None:
        """Read what the terminal still sends, so that the shell gets nothing of it."""
        if self._answers and not self.exit_event.is_set():
            self._ending = True
            self.discard_output()
            self._disable_mouse_support()
            self.write(_LAST_QUESTION)
            self._last_answer.wait(_LAST_ANSWER_S)
            self._answers = False
        super().disable_input()

    def run_input_thread(self) -> None:
        """Read until the console ends, in a thread of Textual."""
        decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
        parser, stream = SturdyParser(self._debug), InputStream(understood)
        with selectors.DefaultSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                data = b""
                if selector.select(self._longest_wait(stream)):
                    data = self._read()
                    if not data:
                        self._app.call_later(self._app.action_quit)
                        return
                parser = self.take(parser, stream, decode(data))

    def _longest_wait(self, stream: InputStream) -> float:
        """Longest time without input until something is due [s]."""
        if self._speed.waits:
            return TOGETHER_S
        return HOLD_S / 2 if stream.holding else _READ_S

    def _read(self) -> bytes:
        try:
            return os.read(self.fileno, 4096)
        except OSError:  # the terminal is lost
            return b""

    def take(self, parser: SturdyParser, stream: InputStream, text: str) -> SturdyParser:
        """Post the events in `text`; returns the parser for the next text."""
        try:
            for part in stream.feed(text, time.monotonic()):
                self._take_part(parser, part)
            self._type(self._speed.idle(time.monotonic()))
            for event in parser.tick():
                self._post(event)
            if self._dropped_move is not None:
                self._post(self._dropped_move)
        except Exception:  # no input of a terminal may end the console
            _logger.exception("input %r could not be read", text[:80])
            self._drop()
            return SturdyParser(self._debug)
        return parser

    def _take_part(self, parser: SturdyParser, part: InputPart) -> None:
        match part:
            case CursorReport(row=row):
                self._answers = True
                if self._ending and row == _LAST_ROW:
                    self._last_answer.set()
                self.process_message(FrameAnswered(part, time.monotonic()))
            case KeyReport():
                self._post_key(parser, part)
            case KeyboardReport():
                self.process_message(ReleasesReported(reported=part.reports_releases))
            case Paste(text=text, whole=True):
                self._post(events.Paste(text.replace("\x00", "")))
            case Paste(text=text):
                keys = map(parser.keys_of, text[:_MOST_PASTED])
                self._drop(tuple(chain.from_iterable(keys)), pasted=True)
            case BrokenSequence():
                self._drop()
            case str():
                self._read_events(parser, _STALE.sub("", part))

    def _read_events(self, parser: SturdyParser, text: str) -> None:
        """Post what a read brought: keys after those of the paste that they may belong to."""
        found = parser.feed(text) if text else ()
        read = [meant for event in found for meant in parser.meant(event)]
        strokes = [self._stroke(each) for each in read if isinstance(each, events.Key)]
        for event in read:
            if not isinstance(event, events.Key):
                self._post(event)
        self._type(self._speed.take(strokes, time.monotonic()))

    def _stroke(self, key: events.Key) -> Stroke[events.Key]:
        text = key.is_printable or key.key in _TYPES_TEXT
        acts_at_once = getattr(self._app, "acts_at_once", None)
        at_once = acts_at_once is not None and acts_at_once(key)
        return Stroke(key=key.key, text=text, at_once=at_once, event=key)

    def _type(self, strokes: Iterable[Stroke[events.Key] | PastedKeys[events.Key]]) -> None:
        for each in strokes:
            if isinstance(each, Stroke):
                self._post(each.event)
            else:
                self._drop(tuple(stroke.event for stroke in each.strokes), pasted=True)

    def _drop(self, keys: tuple[events.Key, ...] = (), *, pasted: bool = False) -> None:
        self.process_message(KeysDropped(keys, pasted=pasted))

    def _post_key(self, parser: SturdyParser, report: KeyReport) -> None:
        """Post a key's move, with the name from its press: Shift may change while a key is down."""
        down = self._down
        if report.move is KeyMove.RELEASE:
            keys = down.pop(report.code, ())
        elif report.move is KeyMove.REPEAT and report.code in down:
            keys = down[report.code]
        else:
            found = parser.keys_of(report.press)
            keys = tuple((key.key, key.character, report.keypad, report.base) for key in found)
            if report.code in down or len(down) >= _MOST_DOWN:
                lost = report.code if report.code in down else next(iter(down))
                self._post_keys(down.pop(lost), KeyMove.RELEASE)
            down[report.code] = keys
        self._post_keys(keys, report.move)

    def _post_keys(self, keys: tuple[_Key, ...], move: KeyMove) -> None:
        for key, character, keypad, base in keys:
            self.process_message(KeyMoved(key, character, move, keypad, base))

    def _post(self, event: Message) -> None:
        """Post an event; drop a move of the mouse if the console is behind."""
        busy = self._app.message_queue_size > _MOST_WAITING
        if busy and isinstance(event, _MOVES):
            if isinstance(event, events.MouseMove):
                self._dropped_move = event
            return
        if isinstance(event, events.MouseEvent):
            self._dropped_move = None
        self.process_message(event)
