"""What keys and devices become before anything else sees them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEvent:
    """A key went down, repeated, or went up.

    Attributes:
        key: Key name, lower case, such as "w", "up", "ctrl+c".
        pressed: Whether it went down (or repeats); False when it went up.
        repeat: Whether it was down already.
    """

    key: str
    pressed: bool
    repeat: bool = False
