"""Numbers of senders in what a robot says: those of this side's clients have others here; pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from hub.errors import CodecError
from hub.gcm.control import CONTROL_REFUSAL, CONTROL_STATE
from hub.gcm.mapping import POINT_REFUSAL
from hub.gcm.navigation import NAVIGATION_STATUS
from hub.ipc.definition import MessageDefinition

_FIELDS: Mapping[str, tuple[MessageDefinition[Any], tuple[str, ...]]] = {
    definition.name: (definition, fields)
    for definition, fields in (
        (CONTROL_STATE, ("owner", "asker")),
        (CONTROL_REFUSAL, ("sender", "owner")),
        (NAVIGATION_STATUS, ("sender", "driver")),
        (POINT_REFUSAL, ("sender",)),
    )
}
"""The messages that name senders by their number at central, and their fields."""


def renumbered(
    name: str, fingerprint: int, payload: memoryview, numbers: Mapping[int, int]
) -> memoryview:
    """A payload with the numbers that senders have here.

    Args:
        name: Of the message.
        fingerprint: Of its format.
        payload: As the robot's hub sent it.
        numbers: The number here, by the one at the robot's hub.

    Returns:
        The payload; unchanged where it names none of these senders, or cannot be read.
    """
    known = _FIELDS.get(name)
    if known is None or not numbers or known[0].fingerprint != fingerprint:
        return payload
    definition, fields = known
    try:
        value = definition.decode(payload)
        changes = {
            field: numbers[number]
            for field in fields
            if (number := getattr(value, field)) in numbers
        }
        if not changes:
            return payload
        return memoryview(b"".join(definition.encode(dataclasses.replace(value, **changes))))
    except CodecError:
        return payload  # its receivers say so
