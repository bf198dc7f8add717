"""What the console itself is doing, apart from any robot."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsoleState:
    """What the console is doing.

    Attributes:
        now: The console's monotonic clock [s].
        held: Keys that count as held down, in the order they were pressed.
        run_number: The layout's run number.
    """

    now: float
    held: tuple[str, ...] = ()
    run_number: int = 0
