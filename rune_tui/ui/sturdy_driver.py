"""Textual's driver for Unix terminals, made so that no input can end the console.

Textual's own ends it at the first byte that is not UTF-8 and at escape sequences with numbers it
cannot use, and reads on for ever when the terminal has gone.
"""

from __future__ import annotations

import codecs
import itertools
import logging
import os
import selectors

from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver

_logger = logging.getLogger(__name__)


class SturdyDriver(LinuxDriver):
    """Takes any bytes; a terminal that has gone ends the console in order."""

    def run_input_thread(self) -> None:
        """Read until the console ends; Textual calls this in a thread of its own."""
        decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
        parser = XTermParser(self._debug)
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

    def _take(self, parser: XTermParser, text: str) -> XTermParser:
        """Hand on the events in `text`; the parser for what comes next."""
        try:
            for event in itertools.chain(parser.feed(text) if text else (), parser.tick()):
                self.process_message(event)
        except Exception:  # whatever a terminal sends, the console goes on
            _logger.exception("input %r could not be read", text[:80])
            return XTermParser(self._debug)
        return parser
