"""Which consoles there are for a gamepad that is sent, and which of them use it; pure."""

from __future__ import annotations

from dataclasses import dataclass

from hub.gcm.pad import CONSOLE_HZ, PadConsole
from rune_tui.controls.devices.matching import plain_text

FORGOTTEN_S = 3.0 / CONSOLE_HZ
"""A console that was not heard for so long is not there any more [s]."""
MOST_CONSOLES = 16
"""Those that are known at a time; others are left out."""


@dataclass(frozen=True, slots=True)
class _Console:
    """A console that has told of itself.

    Attributes:
        operator: Who sits there.
        taken: Numbers of the senders whose gamepads it uses.
        heard: When it told so [s].
    """

    operator: str
    taken: frozenset[int]
    heard: float


class Audience:
    """The consoles at a hub, as they tell of themselves."""

    def __init__(self, operator: str = "") -> None:
        """Prepare.

        Args:
            operator: Whose console the gamepad is for; empty: any.
        """
        self._operator = operator
        self._consoles: dict[int, _Console] = {}

    def hear(self, number: int, told: PadConsole, now: float) -> None:
        """A console tells of itself.

        Args:
            number: Its number at the hub.
            told: What it tells.
            now: The time now [s].
        """
        self._forget(now)
        if number in self._consoles or len(self._consoles) < MOST_CONSOLES:
            operator = plain_text(told.operator) or "somebody"
            self._consoles[number] = _Console(operator, frozenset(told.taken.tolist()), now)

    def words(self, sender: int, now: float) -> str:
        """Whether anybody uses the gamepad, and for whom it waits if nobody does.

        Args:
            sender: The number at the hub of who sends it.
            now: The time now [s].
        """
        self._forget(now)
        meant = [c for c in self._consoles.values() if self._operator in {"", c.operator}]
        if takers := [console for console in meant if sender in console.taken]:
            return f"used by the console of {_names(takers)}"
        if meant:
            return f"not used by the console of {_names(meant)}, which has no free joystick for it"
        whose = f" of {self._operator}" if self._operator else ""
        others = _names(list(self._consoles.values()))
        return f"waits for a console{whose}{f' (there: {others})' if others else ''}"

    def _forget(self, now: float) -> None:
        self._consoles = {
            number: console
            for number, console in self._consoles.items()
            if now - console.heard <= FORGOTTEN_S
        }


def _names(consoles: list[_Console]) -> str:
    return ", ".join(sorted({console.operator for console in consoles}))
