"""What a widget wants done; the app does it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hub.ipc.definition import MessageDefinition


@dataclass(frozen=True, slots=True, kw_only=True)
class SendEffect:
    """Publish a message to a robot.

    Attributes:
        robot: The robot's name in the layout.
        definition: Which message.
        value: Its value.
    """

    robot: str
    definition: MessageDefinition[Any]
    value: Any


@dataclass(frozen=True, slots=True)
class QuitEffect:
    """End the console."""


Effect = SendEffect | QuitEffect
