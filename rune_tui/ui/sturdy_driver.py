"""Textual's driver for Unix terminals, made so that no input can end the console.

Textual's own ends it at the first byte that is not UTF-8 and at escape sequences with numbers it
cannot use, and reads on for ever when the terminal has gone. It does not hear of a button that goes
up beyond the upper left corner, and a mouse that moves faster than the console can follow holds up
every key behind it.
"""

from __future__ import annotations

import codecs
import logging
import os
import re
import selectors
import time
from collections.abc import Iterable
from typing import Final

from textual import events
from textual.message import Message

from rune_tui.terminal.input_stream import (
    HOLD_S,
    CursorReport,
    InputStream,
    KeyboardReport,
    KeyMove,
    KeyReport,
)
from rune_tui.ui.driver_reports import FrameAnswered, KeyMoved, ReleasesReported
from rune_tui.ui.textual_inside import (
    InsideDriver,
    KeyParser,
    is_understood,
    writes_block,
)

_logger = logging.getLogger(__name__)

_MOST_WAITING: Final = 8
"""Messages that wait in the console before what the mouse only moves is left out."""
_MOVES: Final = (events.MouseMove, events.MouseScrollUp, events.MouseScrollDown)
_BEYOND: Final = re.compile(r";(-\d+|0)(?=[;Mm])")
"""Columns and rows of the mouse that are left of or above the terminal."""
_PASSED: Final = re.compile(r"\x1b\[<(3[2-9]|[45]\d|6[0-3]);-?\d+;-?\d+M(?=\x1b\[<\1;-?\d+;-?\d+M)")
"""Reports of a moving mouse that another one follows at once; reading each takes Textual long."""
_UNUSABLE: Final = re.compile(r"\d{7}|\x1b\[(?!.*t\Z)[\d:]*:|\x1b\[(?!.*t\Z)[\d:]*;\d*:")
"""Numbers that Textual takes for others, and parts of numbers that end its parser."""
_READ_S: Final = 0.1
"""Between two looks at the clock while nothing comes [s]."""
_TELL_RELEASES: Final = "\x1b[=2;2u\x1b[?u"
"""Kitty keyboard protocol: also tell when keys repeat and go up, and say whether you do."""
_MOST_DOWN: Final = 64
"""Keys that can be down at once; with one more, the release of the first was lost."""
_Key = tuple[str, str | None, str]
"""What Textual calls a key, the character it types, and its name if it is one of the keypad."""


def understood(sequence: str) -> bool:
    """Whether Textual knows what an escape sequence means, and can use its numbers."""
    return not _UNUSABLE.search(sequence) and is_understood(sequence)


class SturdyParser(KeyParser):
    """Takes a mouse beyond the upper left corner for one that is at the edge, and F3 for F3."""

    def parse_mouse_code(self, code: str) -> Message | None:
        """The event in a report of the mouse."""
        return super().parse_mouse_code(_BEYOND.sub(";1", code))

    def meant(self, event: Message) -> Iterable[Message]:
        """The event itself; a key for what Textual takes for a cursor in the first row."""
        if not isinstance(event, events.CursorPosition):
            return (event,)
        return self.keys_of(f"\x1b[{event.y + 1};{event.x + 1}R")


class SturdyDriver(InsideDriver):
    """Takes any bytes; a terminal that has gone ends the console in order.

    Attributes:
        lost: Whether something was not written because the terminal takes nothing.
    """

    lost: bool = False
    _down: dict[str, tuple[_Key, ...]]
    """The keys that are down, by what the terminal calls them."""
    _ending: bool = False
    _left_out: events.MouseMove | None = None
    """Where the mouse has gone, if the console was not told."""

    def start_application_mode(self) -> None:
        """Enter the terminal, and ask it to tell when keys go up."""
        self._down = {}
        super().start_application_mode()
        self.write(_TELL_RELEASES)

    def write(self, data: str) -> None:
        """Hand over what is to be written, or lose it if that would hold up the console."""
        if not self._ending and writes_block(self):
            self.lost = True
        else:
            super().write(data)

    def stop_application_mode(self) -> None:
        """Leave the terminal as it was; nothing of that may be lost."""
        self._ending = True
        super().stop_application_mode()
        self._ending = False

    def run_input_thread(self) -> None:
        """Read until the console ends; Textual calls this in a thread of its own."""
        decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
        parser, stream = SturdyParser(self._debug), InputStream(understood)
        with selectors.DefaultSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                data = b""
                if selector.select(HOLD_S / 2 if stream.holding else _READ_S):
                    data = self._read()
                    if not data:
                        self._app.call_later(self._app.action_quit)
                        return
                parser = self.take(parser, stream, decode(data))

    def _read(self) -> bytes:
        try:
            return os.read(self.fileno, 4096)
        except OSError:  # the terminal has gone
            return b""

    def take(self, parser: SturdyParser, stream: InputStream, text: str) -> SturdyParser:
        """Hand on the events in `text`; the parser for what comes next."""
        try:
            for part in stream.feed(text, time.monotonic()):
                match part:
                    case CursorReport():
                        self.process_message(FrameAnswered(part, time.monotonic()))
                    case KeyReport():
                        self._tell_key(parser, part)
                    case KeyboardReport():
                        self.process_message(ReleasesReported(reported=part.tells_releases))
                    case str():
                        self._read_events(parser, _PASSED.sub("", part))
            for event in parser.tick():
                self._hand_on(event)
            if self._left_out is not None:
                self._hand_on(self._left_out)
        except Exception:  # whatever a terminal sends, the console goes on
            _logger.exception("input %r could not be read", text[:80])
            return SturdyParser(self._debug)
        return parser

    def _read_events(self, parser: SturdyParser, text: str) -> None:
        for event in parser.feed(text) if text else ():
            for meant in parser.meant(event):
                self._hand_on(meant)

    def _tell_key(self, parser: SturdyParser, report: KeyReport) -> None:
        """Tell the console of a key, by the name that it had when it went down.

        With Shift it is another one, and that may come or go while a key is down.
        """
        down = self._down
        if report.move is KeyMove.RELEASE:
            keys = down.pop(report.code, ())
        elif report.move is KeyMove.REPEAT and report.code in down:
            keys = down[report.code]
        else:
            found = parser.keys_of(report.press)
            keys = tuple((key.key, key.character, report.keypad) for key in found)
            if report.code in down or len(down) >= _MOST_DOWN:
                lost = report.code if report.code in down else next(iter(down))
                self._tell_keys(down.pop(lost), KeyMove.RELEASE)
            down[report.code] = keys
        self._tell_keys(keys, report.move)

    def _tell_keys(self, keys: tuple[_Key, ...], move: KeyMove) -> None:
        for key, character, keypad in keys:
            self.process_message(KeyMoved(key, character, move, keypad))

    def _hand_on(self, event: Message) -> None:
        """Tell the console, unless it is behind and this is but the mouse on its way."""
        busy = self._app.message_queue_size > _MOST_WAITING
        if busy and isinstance(event, _MOVES):
            if isinstance(event, events.MouseMove):
                self._left_out = event
            return
        if isinstance(event, events.MouseEvent):
            self._left_out = None
        self.process_message(event)
