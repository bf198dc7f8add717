"""What the keys of a terminal mean in the open layout."""

from __future__ import annotations

from collections.abc import Iterable

from textual import events

from rune_tui.controls.keyboard import name_of_key, without_shift
from rune_tui.controls.keyboard_layouts import us_key
from rune_tui.layout.names import SHIFT, canonical_key
from rune_tui.model.control import Standing, standing
from rune_tui.model.own_keys import own_key
from rune_tui.model.robot_state import RobotState
from rune_tui.ui.current_layout import CurrentLayout

_MOST_NAMED = 8
"""Number of keys that do nothing and are named to the operator."""


class KeyNames:
    """Names of keys in the open layout, and which of them drive or stop."""

    def __init__(self, current: CurrentLayout) -> None:
        """Take the open layout."""
        self._current = current
        self._takes_control = True
        self._named: set[str] = set()

    def follow(self, robots: Iterable[RobotState]) -> None:
        """Note whether a key that drives may take control of a robot."""
        self._takes_control = any(standing(each) is Standing.FREE for each in robots)

    def named(self, key: str, character: str | None, base: str = "") -> tuple[str, bool]:
        """The input name of a key, and whether Shift makes it finer; a binding with Shift wins.

        A character that the layout does not bind counts as the same key of a US keyboard.

        Args:
            key: Textual's name of it.
            character: What it types, if anything.
            base: What it types on a US keyboard, by the terminal; empty: not reported.
        """
        name, fine = self._typed(key, character)
        if not self._is_bound(name):
            letter = name.isascii() and name.isalpha()
            other = canonical_key("" if letter else base or us_key(name))
            if other and self._is_bound(other):
                return other, fine
        return name, fine

    def unbound(self, name: str) -> str:
        """Words for a key of another script that does nothing, once for each; else empty."""
        foreign = len(name) == 1 and not name.isascii() and not self._is_bound(name)
        if not foreign or name in self._named or len(self._named) >= _MOST_NAMED:
            return ""
        self._named.add(name)
        return f"{name} (U+{ord(name):04X}) is bound to nothing: switch to Latin letters"

    def _is_bound(self, name: str) -> bool:
        return self._current.dispatch.waits_for(name) or own_key(name) is not None

    def _typed(self, key: str, character: str | None) -> tuple[str, bool]:
        name, plain = name_of_key(key, character), without_shift(key, character)
        if plain and self._current.dispatch.waits_for(SHIFT + plain):
            return SHIFT + plain, False
        fine = bool(plain) and (name == plain or not self._current.dispatch.waits_for(name))
        return (plain, True) if fine else (name, False)

    def drives(self, name: str) -> bool:
        """Whether an input acts while it is held."""
        return self._current.dispatch.waits_for_hold(name)

    def stops(self, key: events.Key) -> str:
        """The input name of a stop key; else empty."""
        name, _ = self.named(key.key, key.character)
        return name if self._current.dispatch.stops(name) else ""

    def acts_at_once(self, key: events.Key) -> bool:
        """Whether a key drives or stops, so that it must not wait for the next one.

        The driver's thread calls this too. A key that may take control waits.
        """
        name, _ = self.named(key.key, key.character)
        drives = self.drives(name) and not self._takes_control
        return drives or self._current.dispatch.stops(name)
