"""The experimenter's screen: how far a session is, and orders to it."""

from __future__ import annotations

import time
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.containers import Horizontal, VerticalScroll
from textual.widgets import Input, Static

from hub.plain_text import plain
from rune_study.errors import StudyError
from rune_study.plan.steps import plan
from rune_study.plan.study_spec import StudySpec
from rune_study.session.journal import BEGIN as BEGUN
from rune_study.session.journal import DONE, Record, journal_path, read_journal
from rune_study.session.orders import ABORT, BEGIN, END, MARK, NOTE, PAUSE, give_order
from rune_study.session.status import progress_in

_LOOK_S = 0.3
_KEYS = "b begin   p pause   e end trial   a abort   m mark   n note   q quit"
_LINES = 200
_AGAIN_S = 3.0
"""Time within which the key that aborts has to be pressed twice [s]."""


class WatchScreen(App[None]):
    """Shows steps and journal of one participant; codes only."""

    CSS = """
    #steps { width: 34; border-right: solid $accent; padding: 0 1; }
    #events { padding: 0 1; }
    #keys { dock: bottom; height: 1; }
    Input { dock: bottom; display: none; }
    """
    AUTO_FOCUS = ""  # keys are orders until a note is written
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar = [
        ("b", f"order('{BEGIN}')", "Begin"),
        ("p", f"order('{PAUSE}')", "Pause"),
        ("e", f"order('{END}')", "End"),
        ("a", "abort", "Abort"),
        ("m", f"order('{MARK}')", "Mark"),
        ("n", "note", "Note"),
        ("q", "quit", "Quit"),
    ]

    def __init__(self, study: StudySpec, participant: int) -> None:
        """Watch a participant of a study."""
        super().__init__()
        self._study = study
        self._participant = participant
        self._path = journal_path(study.folder, participant)
        self._abort_at = float("-inf")

    def compose(self) -> ComposeResult:
        """Steps, journal, keys, and the line of notes."""
        with Horizontal():
            with VerticalScroll(id="steps"):
                yield Static(id="list", markup=False)
            with VerticalScroll(id="events"):
                yield Static(id="journal", markup=False)
        yield Static(_KEYS, id="keys", markup=False)
        yield Input(placeholder="a note; Enter writes it")

    def on_mount(self) -> None:
        """Look at the journal now, and again and again."""
        self._look()
        self.set_interval(_LOOK_S, self._look)

    def action_order(self, do: str) -> None:
        """Give an order without words."""
        self._give(do, "")

    def action_abort(self) -> None:
        """Have the session left, at the second press."""
        now = time.monotonic()
        if now - self._abort_at < _AGAIN_S:
            self._give(ABORT, "")
        else:
            self._abort_at = now
            self._say("press a again to leave the session")

    def action_note(self) -> None:
        """Open the line of notes."""
        line = self.query_one(Input)
        line.display = True
        line.focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Write a note."""
        if event.value.strip():
            self._give(NOTE, event.value.strip())
        event.input.value = ""
        event.input.display = False
        self.set_focus(None)

    def _give(self, do: str, text: str) -> None:
        try:
            give_order(self._path.parent, do, text)
        except StudyError as error:
            self._say(str(error))
        else:
            self._say(f"{do} is ordered")

    def _say(self, text: str) -> None:
        self.query_one("#keys", Static).update(f"{plain(text)}   |   {_KEYS}")

    def _look(self) -> None:
        if not self._path.exists():
            self.query_one("#list", Static).update(
                f"participant {self._participant} has not begun yet"
            )
            return
        records = read_journal(self._path)
        self.query_one("#list", Static).update("\n".join(self._steps(records)))
        journal = self.query_one("#journal", Static)
        journal.update("\n".join(line_of(each) for each in records[-_LINES:]))
        self.query_one("#events", VerticalScroll).scroll_end(animate=False)

    def _steps(self, records: list[Record]) -> list[str]:
        progress = progress_in(self._study, self._participant, records)
        done = {each.data["n"] for each in records if each.what == DONE}
        lines = [f"participant {self._participant}   {progress.done} of {progress.steps}", ""]
        for step in plan(self._study, self._participant, progress.replaces):
            sign = "x" if step.number in done else ">" if step.name == progress.now else " "
            lines.append(f"{sign} {step.name} {step.code if step.trial else ''}".rstrip())
        return lines


def line_of(record: Record) -> str:
    """A record in one line, without what blinds or identifies."""
    shown = ("step", "code", "attempt", "number", "do", "text", "why", "key", "correct", "seconds")
    words = [str(record.data[name]) for name in shown if record.data.get(name) not in (None, "")]
    if record.what == BEGUN and "attempt" in record.data:
        words[-1:] = [f"attempt {record.data['attempt']}"]
    clock = time.strftime("%H:%M:%S", time.localtime(record.at))
    return plain(f"{clock} {record.what} {' '.join(words)}".rstrip())
