"""What the door of a hub for panels calls itself, so that no hub takes it for a robot; pure."""

from __future__ import annotations

_OWNER = "Rune"
PANEL_DOOR_SERVER = "Rune-door-for-panels"
"""What such a door calls itself in answers of HTTP, also to programs without its key."""


def panel_door_name(robot: str) -> str:
    """The name of the door of a robot's hub; the robot's name may be empty."""
    return f"{_OWNER}: {robot}" if robot else _OWNER


def is_panel_door(name: object) -> bool:
    """Whether a server for panels that calls itself so is the door of a hub."""
    return isinstance(name, str) and (name == _OWNER or name.startswith(f"{_OWNER}: "))
