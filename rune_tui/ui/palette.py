"""The list of all that the layout's inputs do, to search and to choose from: Textual's palette."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from textual.command import CommandPalette, DiscoveryHit, Hit, Hits, Provider
from textual.content import Content

from rune_tui.help_layer import robot_words
from rune_tui.layout.actions import Action

Act = Callable[[Action], None]


def palette_of(actions: Sequence[Action], act: Act) -> CommandPalette:
    """The palette of what can be done in a moment.

    Args:
        actions: All actions.
        act: Called with the one that is chosen.
    """
    listed = {_title(action): action for action in actions if action.at_once}

    class Actions(Provider):
        """Finds actions by their words."""

        async def discover(self) -> Hits:
            """All of them, before anything is typed."""
            for title, action in listed.items():
                yield DiscoveryHit(Content(title), partial(act, action), title, _inputs(action))

        async def search(self, query: str) -> Hits:
            """Those that match what is typed, with how well they do."""
            matcher = self.matcher(query)
            for title, action in listed.items():
                if (score := matcher.match(title)) > 0.0:
                    marked = matcher.highlight(title)
                    yield Hit(score, marked, partial(act, action), title, _inputs(action))

    return CommandPalette([Actions], placeholder="What shall be done?")


def _title(action: Action) -> str:
    return f"{robot_words(action.robot)}: {action.words}"


def _inputs(action: Action) -> str:
    return ", ".join(action.inputs)
