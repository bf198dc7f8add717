"""What is known of a joystick of the layout at one moment; immutable."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field


class JoystickPhase(enum.Enum):
    """How a joystick of the layout stands to a device."""

    CONNECTED = "connected"
    MISSING = "missing"
    FORBIDDEN = "no permission"
    UNSUITABLE = "unsuitable"


class Absence(enum.Enum):
    """What is known of a device that is gone.

    Attributes:
        UNPLUGGED: It was unplugged, where it was.
        ENDED: What sent it from another machine has ended.
        SILENT: Nothing comes from the other machine, and nobody knows why.
    """

    UNPLUGGED = "unplugged"
    ENDED = "ended"
    SILENT = "silent"


@dataclass(frozen=True, slots=True, kw_only=True)
class JoystickState:
    """A joystick of the layout.

    Attributes:
        name: What the layout calls it.
        device: The device's own name; what it was, if it is gone; empty if there never was one.
        phase: Whether it can be used.
        why: What is wrong, and what to do about it; empty if nothing is.
        values: How far each control is moved, -1 to 1, by the control's name; a hat's directions
            are "pov up" and so on. What the device has not told of yet is missing.
        waiting: Names of axes that are moved, and have to be let go of before they count.
        heard: When one of its controls moved last [s]; None if none has.
        prompt: What the operator is asked to do with it now; empty if nothing.
        machine: Where its device is plugged in; empty for this machine.
        measured: When the newest of what came from there was measured [s]; None if nothing comes.
        absence: What became of its device, if it is gone.
    """

    name: str
    device: str = ""
    phase: JoystickPhase = JoystickPhase.MISSING
    why: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    waiting: frozenset[str] = frozenset()
    heard: float | None = None
    prompt: str = ""
    machine: str = ""
    measured: float | None = None
    absence: Absence = Absence.UNPLUGGED

    @property
    def lost(self) -> bool:
        """Whether there was a device, and it is gone."""
        return self.phase is JoystickPhase.MISSING and bool(self.device)
