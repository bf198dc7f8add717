"""Textual's driver for Unix terminals, made so that no input can end the console.

Textual's own ends it at the first byte that is not UTF-8 and at escape sequences with numbers it
cannot use, and reads on for ever when the terminal has gone. It does not hear of a button that goes
up beyond the upper left corner, and a mouse that moves faster than the console can follow holds up
every key behind it.
"""

from __future__ import annotations

import codecs
import itertools
import logging
import os
import re
import selectors
from typing import Final

from textual import events
from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver
from textual.message import Message

_logger = logging.getLogger(__name__)

_MOST_WAITING: Final = 8
"""Messages that wait in the console before what the mouse only moves is left out."""
_MOVES: Final = (events.MouseMove, events.MouseScrollUp, events.MouseScrollDown)
_BEYOND: Final = re.compile(r";(-\d+|0)(?=[;Mm])")
"""Columns and rows of the mouse that are left of or above the terminal."""
_PASSED: Final = re.compile(r"\x1b\[<(3[2-9]|[45]\d|6[0-3]);-?\d+;-?\d+M(?=\x1b\[<\1;-?\d+;-?\d+M)")
"""Reports of a moving mouse that another one follows at once; reading each takes Textual long."""


class SturdyParser(XTermParser):
    """Takes a mouse beyond the upper left corner for one that is at the edge."""

    def parse_mouse_code(self, code: str) -> Message | None:
        """The event in a report of the mouse."""
        return super().parse_mouse_code(_BEYOND.sub(";1", code))


class SturdyDriver(LinuxDriver):
    """Takes any bytes; a terminal that has gone ends the console in order."""

    _left_out: events.MouseMove | None = None
    """Where the mouse has gone, if the console was not told."""

    def run_input_thread(self) -> None:
        """Read until the console ends; Textual calls this in a thread of its own."""
        decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
        parser = SturdyParser(self._debug)
        with selectors.DefaultSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                data = b""
                if selector.select(0.1):
                    data = self._read()
                    if not data:
                        self._app.call_later(self._app.action_quit)
                        return
                parser = self._take(parser, decode(data))

    def _read(self) -> bytes:
        try:
            return os.read(self.fileno, 4096)
        except OSError:  # the terminal has gone
            return b""

    def _take(self, parser: SturdyParser, text: str) -> SturdyParser:
        """Hand on the events in `text`; the parser for what comes next."""
        text = _PASSED.sub("", text)
        try:
            for event in itertools.chain(parser.feed(text) if text else (), parser.tick()):
                self._hand_on(event)
            if self._left_out is not None:
                self._hand_on(self._left_out)
        except Exception:  # whatever a terminal sends, the console goes on
            _logger.exception("input %r could not be read", text[:80])
            return SturdyParser(self._debug)
        return parser

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
