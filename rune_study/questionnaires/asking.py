"""Asks a questionnaire in this terminal: one item a screen, each answer saved before the next."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.events import Key, MouseDown, Resize
from textual.geometry import Size
from textual.widgets import Static

from rune_study.questionnaires.answers import Answers, GivenAnswer
from rune_study.questionnaires.entries import WIDTH, Entry, Grounds, entry_of, wrapped
from rune_study.questionnaires.items import Agreement, Answer, ComparedItem, Item
from rune_study.questionnaires.questionnaire import Questionnaire
from rune_study.questionnaires.spatial_entries import PlaceEntry

_MARGIN = 2
_UNKNOWN = "escape"
"""The key of who does not know the answer to a question with a truth."""


def ask(
    questionnaire: Questionnaire,
    answers: Path,
    occasion: str,
    seed: str,
    *,
    grounds: Grounds | None = None,
    given: Callable[[GivenAnswer], None] | None = None,
) -> bool:
    """Ask what is not answered yet.

    Args:
        questionnaire: The questionnaire.
        answers: The person's file of answers.
        occasion: When in the session this is, such as "t3".
        seed: Decides the order of the items for this person.
        grounds: What questions about places show.
        given: Gets each answer once it is on the disk.

    Returns:
        Whether all is answered; False: the person did not agree, or pressed Ctrl-C.

    Raises:
        AnswersError: Answers cannot be written, or do not fit.
    """
    with Answers(answers) as file:
        screen = QuestionnaireScreen(questionnaire, file, occasion, seed, grounds, given)
        return bool(screen.run())


def is_refused(questionnaire: Questionnaire, answers: Path, occasion: str) -> bool:
    """Whether the person did not agree to what the questionnaire asks.

    Raises:
        AnswersError: The answers cannot be read, or do not fit.
    """
    with Answers(answers) as given:
        return _refuses(questionnaire, given.of(questionnaire, occasion))


def _refuses(questionnaire: Questionnaire, given: Mapping[str, Answer | None]) -> bool:
    items = questionnaire.items
    return any(isinstance(item, Agreement) and given.get(item.id) is False for item in items)


class QuestionnaireScreen(App[bool]):
    """The screens of a questionnaire; ends with whether all is answered.

    A terminal that cannot show a question as a whole says so, and takes no answer.
    """

    CSS = f"""
    Screen {{ align: center middle; }}
    #item {{ width: {WIDTH + 2 * _MARGIN}; height: auto; max-height: 100%; padding: 0 {_MARGIN}; }}
    """
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar = [("ctrl+c", "leave", "Leave")]

    def __init__(
        self,
        questionnaire: Questionnaire,
        answers: Answers,
        occasion: str,
        seed: str,
        grounds: Grounds | None = None,
        given: Callable[[GivenAnswer], None] | None = None,
    ) -> None:
        """Begin at the first item without an answer; see `ask`."""
        super().__init__()
        self._questionnaire = questionnaire
        self._answers = answers
        self._occasion = occasion
        self._grounds = grounds
        self._given = given
        self._items = questionnaire.order(seed)
        done = answers.of(questionnaire, occasion)
        self._open = [item for item in self._items if item.id not in done]
        self._refused = _refuses(questionnaire, done)
        begins = bool(questionnaire.instructions) and len(self._open) == len(self._items)
        self._unread = wrapped(questionnaire.instructions) if begins else []
        self._entry = self._next_entry()
        self._since = time.monotonic()
        self._room = Size(0, 0)
        self._fits = False

    def compose(self) -> ComposeResult:
        """Make the only widget."""
        yield Static(id="item", markup=False)

    def on_mount(self) -> None:
        """Show the first item."""
        self._room = self.size
        self._show()

    def on_resize(self, event: Resize) -> None:
        """Show the item on the new screen."""
        self._room = event.size
        self._show()

    def on_key(self, event: Key) -> None:
        """Pass a key to the item."""
        if event.key == "ctrl+c":
            return
        event.prevent_default()
        event.stop()
        if not self._fits:
            return
        if self._unread:
            if event.key == "enter":
                self._unread = self._unread[self._page :]
                self._since = time.monotonic()
        elif self._entry is not None:
            value = self._entry.press(event.key, event.character)
            if value is not None or (event.key == _UNKNOWN and self._may_be_unknown):
                self._save(self._open[0], value)
        self._show()

    def on_mouse_down(self, event: MouseDown) -> None:
        """Pass a click on the ground to its item."""
        if isinstance(self._entry, PlaceEntry) and self._fits and not self._unread:
            corner = self.query_one("#item").content_region
            above = len(self._head())
            self._entry.click(event.screen_x - corner.x, event.screen_y - corner.y - above)
            self._show()

    def action_leave(self) -> None:
        """End; what is answered stays."""
        self.exit(result=False)

    @property
    def _may_be_unknown(self) -> bool:
        return isinstance(self._open[0], ComparedItem) and bool(self._open[0].truth)

    @property
    def _page(self) -> int:
        """Lines of the instructions that fit on the screen."""
        return max(1, self._room.height - 4)

    def _next_entry(self) -> Entry | None:
        return entry_of(self._open[0], self._grounds) if self._open else None

    def _save(self, item: Item, value: Answer | None) -> None:
        seconds = time.monotonic() - self._since
        given = self._answers.give(self._questionnaire, self._occasion, item, value, seconds)
        if self._given is not None:
            self._given(given)
        self._refused |= isinstance(item, Agreement) and value is False
        del self._open[0]
        self._entry = self._next_entry()
        self._since = time.monotonic()

    def _show(self) -> None:
        if self._refused or self._entry is None:
            self.exit(not self._refused)
            return
        lines = self._lines(self._entry)
        width, height = self._room.width, self._room.height
        self._fits = width >= WIDTH + 2 * _MARGIN and height >= len(lines)
        if not self._fits:
            need = f"{WIDTH + 2 * _MARGIN}x{max(len(lines), 24)}"
            lines = ["Please make this", "window larger:", f"{width}x{height}, not", need]
        self.query_one("#item", Static).update("\n".join(lines))

    def _head(self) -> list[str]:
        """What is above the entry."""
        item = self._open[0]
        number = len(self._items) - len(self._open) + 1
        title = [item.title] if item.title else []
        count = f"{self._questionnaire.title}   {number} of {len(self._items)}"
        return [count, "", *title, *wrapped(item.text), ""]

    def _lines(self, entry: Entry) -> list[str]:
        if self._unread:
            more = len(self._unread) > self._page
            keys = "Enter: read on" if more else "Enter: begin"
            return [self._questionnaire.title, "", *self._unread[: self._page], "", keys]
        head = self._head()
        unknown = ["Esc: I do not know"] if self._may_be_unknown else []
        if isinstance(entry, PlaceEntry):
            entry.fit(WIDTH, self._room.height - len(head) - len(unknown))
        return [*head, *entry.lines(), *unknown]
