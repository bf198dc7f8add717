"""Which consoles there are for a gamepad that is sent, and which of them use it; pure."""

from __future__ import annotations

from hub.gcm.pad import CONSOLE_HZ, PadConsole
from hub.values import dataclass
from rune_tui.controls.devices.matching import plain_text

FORGOTTEN_S = 3.0 / CONSOLE_HZ
"""Silence after which a console counts as gone [s]."""
MOST_CONSOLES = 16
"""Largest number of consoles; further ones are left out."""


@dataclass(frozen=True, slots=True)
class _Console:
    """A console that has announced itself.

    Attributes:
        operator: Its operator.
        taken: Numbers of the senders of its gamepads.
        heard: Time of its newest announcement [s].
    """

    operator: str
    taken: frozenset[int]
    heard: float


class Audience:
    """The consoles at a hub, by their announcements."""

    def __init__(self, operator: str = "") -> None:
        """Prepare.

        Args:
            operator: Operator of the console that may use the gamepad; empty: any.
        """
        self._operator = operator
        self._consoles: dict[int, _Console] = {}

    def hear(self, number: int, announced: PadConsole, now: float) -> None:
        """Take an announcement of a console.

        Args:
            number: Its number at the hub.
            announced: The announcement.
            now: The time now [s].
        """
        self._forget(now)
        if number in self._consoles or len(self._consoles) < MOST_CONSOLES:
            operator = plain_text(announced.operator) or "somebody"
            self._consoles[number] = _Console(operator, frozenset(announced.taken.tolist()), now)

    def words(self, sender: int, now: float) -> str:
        """Whether a console uses the gamepad, and for which console it waits.

        Args:
            sender: The sender's number at the hub.
            now: The time now [s].
        """
        self._forget(now)
        meant = [c for c in self._consoles.values() if self._operator in {"", c.operator}]
        if takers := [console for console in meant if sender in console.taken]:
            return f"used by the console of {_names(takers)}"
        if meant:
            return f"not used by the console of {_names(meant)}, which has no free joystick for it"
        operator = f" of {self._operator}" if self._operator else ""
        others = _names(list(self._consoles.values()))
        return f"waits for a console{operator}{f' (there: {others})' if others else ''}"

    def _forget(self, now: float) -> None:
        self._consoles = {
            number: console
            for number, console in self._consoles.items()
            if now - console.heard <= FORGOTTEN_S
        }


def _names(consoles: list[_Console]) -> str:
    return ", ".join(sorted({console.operator for console in consoles}))
