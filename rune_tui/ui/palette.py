"""The list of all actions of a layout, to search and to choose from: Textual's palette."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial

from textual.command import CommandPalette, DiscoveryHit, Hit, Hits, Provider
from textual.content import Content

from rune_tui.layout.actions import Action
from rune_tui.layout.rules import Section
from rune_tui.overlays.help_page import robot_words

_SECTIONS = list(Section)

Act = Callable[[Action], None]


def palette_of(actions: Sequence[Action], act: Act) -> CommandPalette:
    """The palette of some actions.

    Args:
        actions: All actions.
        act: Called with the chosen action.
    """
    listed = choices(actions)

    class Actions(Provider):
        """Finds actions by their words."""

        async def discover(self) -> Hits:
            """All actions, before the operator types."""
            for title, action in listed.items():
                yield DiscoveryHit(Content(title), partial(act, action), title, _inputs(action))

        async def search(self, query: str) -> Hits:
            """Actions that match the query, with their scores."""
            matcher = self.matcher(query)
            missing = True
            for title, action in listed.items():
                if (
                    score := match(query, title, f"{action.help} {action.also}")
                    or min(matcher.match(title), 1.0)
                ) > 0:
                    missing = False
                    marked = matcher.highlight(title)
                    yield Hit(score, marked, partial(act, action), title, _inputs(action))
            if missing:
                text = f"Nothing here is called {query!r}: type less, or Escape"
                yield Hit(0.01, Content(text), lambda: None, text, "F1 shows all keys")

    return CommandPalette([Actions], placeholder="What shall be done?")


def match(query: str, title: str, more: str) -> float:
    """Score of an action for a query: at least 2 if words match, else 0.

    Args:
        query: The operator's text.
        title: Title of the action.
        more: Description of the action.
    """
    wanted, called = query.casefold().split(), title.casefold()
    if not wanted:
        return 0.0
    ranks = (
        called.startswith(" ".join(wanted)),
        _begins_words(wanted, called),
        all(word in called for word in wanted),
        _begins_words(wanted, more.casefold()),
    )
    return next((5.0 - rank for rank, fits in enumerate(ranks) if fits), 0.0)


def _begins_words(wanted: Sequence[str], text: str) -> bool:
    """Whether each of some words begins a word of a text."""
    words = re.findall(r"\w+", text)
    return all(any(word.startswith(begin) for word in words) for begin in wanted)


def choices(actions: Sequence[Action]) -> dict[str, Action]:
    """The actions of the list, in its order."""
    several = len({action.robot for action in actions if action.robot}) > 1
    at_once = sorted((action for action in actions if action.at_once), key=_rank)
    return {_title(action, several=several): action for action in at_once}


def _rank(action: Action) -> tuple[bool, bool, int, bool]:
    """Where an action stands: the first is taken by a careless enter, so it must do no harm."""
    last = action.section is Section.SESSION
    harmless = action.section is Section.SCREEN and action.safe
    return (not harmless, last and action.safe, _SECTIONS.index(action.section), not action.safe)


def _title(action: Action, *, several: bool) -> str:
    prefix = f"{robot_words(action.robot)}: " if several and action.robot else ""
    return f"{prefix}{action.words}"


def _inputs(action: Action) -> str:
    return ", ".join(action.inputs)
