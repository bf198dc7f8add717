"""What the console uses of Textual's inside is there, and is used in one place."""

from __future__ import annotations

import asyncio
import inspect
import re
from pathlib import Path

import textual
from textual import _ansi_sequences, _xterm_parser
from textual._queue import Queue
from textual.app import App
from textual.driver import Driver
from textual.drivers import _writer_thread
from textual.drivers.linux_driver import LinuxDriver
from textual.strip import Strip

import rune_tui
from rune_tui.ui import textual_inside
from tests.support.cases import for_each

FILE = "rune_tui/ui/textual_inside.py"
NAMES = [
    (_ansi_sequences, "ANSI_SEQUENCES_KEYS"),
    (_xterm_parser, "SPECIAL_SEQUENCES"),
    (_xterm_parser, "_re_mouse_event"),
    (_xterm_parser, "_re_terminal_mode_response"),
    (_xterm_parser, "_re_in_band_window_resize"),
    (_xterm_parser, "_re_extended_key"),
    (_xterm_parser.XTermParser, "_sequence_to_key_events"),
    (_xterm_parser.XTermParser, "parse_mouse_code"),
    (LinuxDriver, "_sigtstp_application"),
    (LinuxDriver, "_sigcont_application"),
    (LinuxDriver, "run_input_thread"),
    (Strip, "_segments"),
    (App, "_message_queue"),
    (App, "_handle_exception"),
    (asyncio.Event(), "_waiters"),
]


@for_each(("owner", "name"), NAMES)
def test_textual_has_what_the_console_takes_from_its_inside(owner: object, name: str) -> None:
    where = getattr(owner, "__name__", owner)
    assert hasattr(owner, name), f"Textual {textual.__version__}: {where} has no {name}; see {FILE}"


@for_each(
    ("owner", "words"),
    [
        (App.__init__, "self._driver"),
        (LinuxDriver, "self._writer_thread = WriterThread("),
        (LinuxDriver._sigtstp_application, "self.suspend_application_mode()"),
        (LinuxDriver._sigtstp_application, "self._must_signal_resume = True"),
        (LinuxDriver.write, "self._writer_thread.write(data)"),
        (_writer_thread.WriterThread, "self._queue: Queue"),
        (_writer_thread.WriterThread.run, "if text is None:"),
        (Driver.suspend_application_mode, "self.stop_application_mode()"),
        (Driver.suspend_application_mode, "self.close()"),
        (Driver.process_message, "self.send_message(message)"),
        (Queue.__init__, "self.ready_event = Event()"),
        (Queue.get, "await self.ready_event.wait()"),
        (Strip, '"_cell_count"'),
        (Strip, '"_render_cache"'),
        (LinuxDriver.start_application_mode, "\\x1b[>{KITTY_PROTOCOL_FLAG}u"),
        (LinuxDriver.stop_application_mode, "\\x1b[<u"),
    ],
)
def test_textual_still_does_it_so(owner: object, words: str) -> None:
    said = f"Textual {textual.__version__}: {owner} no longer says {words!r}; see {FILE}"
    assert words in inspect.getsource(owner), said  # type: ignore[arg-type]


def test_nothing_else_reaches_inside_textual() -> None:
    package = Path(inspect.getfile(rune_tui)).parent
    inside = re.compile(
        r"(from|import) textual(\.\w+)*\._|from textual import _|\._driver\b|_writer_thread"
    )
    found = [
        str(path.relative_to(package))
        for path in package.rglob("*.py")
        if inside.search(path.read_text()) and path != Path(inspect.getfile(textual_inside))
    ]
    assert found == []
