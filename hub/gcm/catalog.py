"""The one tuple of all message definitions."""

from __future__ import annotations

from typing import Any

from hub.gcm import navigation, supervision, vision
from hub.ipc.definition import MessageDefinition

MESSAGES: tuple[MessageDefinition[Any], ...] = (
    *navigation.MESSAGES,
    *vision.MESSAGES,
    *supervision.MESSAGES,
)
BY_NAME = {definition.name: definition for definition in MESSAGES}
