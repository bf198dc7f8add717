"""The state of a joystick of the layout at one moment; immutable."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import field

from hub.values import dataclass


class JoystickPhase(enum.Enum):
    """Whether a joystick of the layout has a device."""

    CONNECTED = "connected"
    MISSING = "missing"
    FORBIDDEN = "no permission"
    UNSUITABLE = "unsuitable"


class Absence(enum.Enum):
    """Why a device is gone.

    Attributes:
        UNPLUGGED: It was unplugged.
        ENDED: The sender at the other machine has ended.
        SILENT: The other machine sends nothing; the reason is not known.
    """

    UNPLUGGED = "unplugged"
    ENDED = "ended"
    SILENT = "silent"


@dataclass(frozen=True, slots=True, kw_only=True)
class JoystickState:
    """A joystick of the layout.

    Attributes:
        name: Its name in the layout.
        device: The name of its device, or of the last one; empty: it never had one.
        phase: Whether it can be used.
        why: The fault and the remedy; empty: none.
        values: Position of each control, -1 to 1, by the control's name; a hat's directions are
            "pov up" and so on. Controls without a report yet are missing.
        waiting: Names of axes that are moved and must be released before they count.
        prompt: The instruction to the operator; empty: none.
        machine: The machine of its device; empty: this one.
        measured: Time of the newest state from that machine [s]; None: none.
        absence: The reason for its device's absence, if any.
    """

    name: str
    device: str = ""
    phase: JoystickPhase = JoystickPhase.MISSING
    why: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    waiting: frozenset[str] = frozenset()
    prompt: str = ""
    machine: str = ""
    measured: float | None = None
    absence: Absence = Absence.UNPLUGGED

    @property
    def lost(self) -> bool:
        """Whether there was a device, and it is gone."""
        return self.phase is JoystickPhase.MISSING and bool(self.device)
