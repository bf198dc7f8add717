"""Asks a questionnaire in this terminal: one item a screen, each answer saved before the next."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.events import Key
from textual.widgets import Static

from rune_study.questionnaires.answers import Answers
from rune_study.questionnaires.entries import WIDTH, Entry, entry_of, wrapped
from rune_study.questionnaires.items import Agreement, Answer, Item
from rune_study.questionnaires.questionnaire import Questionnaire


def ask(questionnaire: Questionnaire, answers: Path, occasion: str, seed: str) -> bool:
    """Ask what is not answered yet.

    Args:
        questionnaire: The questionnaire.
        answers: The person's file of answers.
        occasion: When in the session this is, such as "t3".
        seed: Decides the order of the items for this person.

    Returns:
        Whether all is answered; False: the person did not agree, or pressed Ctrl-C.

    Raises:
        AnswersError: Answers cannot be written, or do not fit.
    """
    with Answers(answers) as given:
        return bool(QuestionnaireScreen(questionnaire, given, occasion, seed).run())


def is_refused(questionnaire: Questionnaire, answers: Path, occasion: str) -> bool:
    """Whether the person did not agree to what the questionnaire asks.

    Raises:
        AnswersError: The answers cannot be read, or do not fit.
    """
    with Answers(answers) as given:
        return _refuses(questionnaire, given.of(questionnaire, occasion))


def _refuses(questionnaire: Questionnaire, given: Mapping[str, Answer]) -> bool:
    items = questionnaire.items
    return any(isinstance(item, Agreement) and given.get(item.id) is False for item in items)


class QuestionnaireScreen(App[bool]):
    """The screens of a questionnaire; ends with whether all is answered."""

    CSS = f"""
    Screen {{ align: center middle; }}
    #item {{ width: {WIDTH + 4}; height: auto; max-height: 100%; padding: 0 2; }}
    """
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar = [("ctrl+c", "leave", "Leave")]

    def __init__(
        self, questionnaire: Questionnaire, answers: Answers, occasion: str, seed: str
    ) -> None:
        """Begin at the first item without an answer."""
        super().__init__()
        self._questionnaire = questionnaire
        self._answers = answers
        self._occasion = occasion
        self._items = questionnaire.order(seed)
        done = answers.of(questionnaire, occasion)
        self._open = [item for item in self._items if item.id not in done]
        self._refused = _refuses(questionnaire, done)
        self._reading = bool(questionnaire.instructions) and len(self._open) == len(self._items)
        self._entry: Entry | None = entry_of(self._open[0]) if self._open else None
        self._since = time.monotonic()

    def compose(self) -> ComposeResult:
        """Make the only widget."""
        yield Static(id="item", markup=False)

    def on_mount(self) -> None:
        """Show the first item."""
        self._show()

    def on_key(self, event: Key) -> None:
        """Pass a key to the item."""
        if event.key == "ctrl+c":
            return
        event.prevent_default()
        event.stop()
        if self._reading:
            if event.key == "enter":
                self._reading = False
                self._since = time.monotonic()
        elif self._entry is not None:
            value = self._entry.press(event.key, event.character)
            if value is not None:
                self._save(self._open[0], value)
        self._show()

    def action_leave(self) -> None:
        """End; what is answered stays."""
        self.exit(result=False)

    def _save(self, item: Item, value: Answer) -> None:
        seconds = time.monotonic() - self._since
        self._answers.give(self._questionnaire, self._occasion, item, value, seconds)
        self._refused |= isinstance(item, Agreement) and value is False
        del self._open[0]
        self._entry = entry_of(self._open[0]) if self._open else None
        self._since = time.monotonic()

    def _show(self) -> None:
        if self._refused or self._entry is None:
            self.exit(not self._refused)
            return
        self.query_one("#item", Static).update("\n".join(self._lines(self._entry)))

    def _lines(self, entry: Entry) -> list[str]:
        head = [self._questionnaire.title, ""]
        if self._reading:
            return [*head, *wrapped(self._questionnaire.instructions), "", "Enter: begin"]
        item = self._open[0]
        number = len(self._items) - len(self._open) + 1
        title = [item.title] if item.title else []
        head[0] += f"   {number} of {len(self._items)}"
        return [*head, *title, *wrapped(item.text), "", *entry.lines()]
