"""Reads messages in JSON, with or without a schema: their fields are those that they have."""

from __future__ import annotations

import json
from typing import Any, Final

from hub.errors import RosMessageError

MOST_JSON: Final = 1 << 23
"""Longest message [bytes]; its values take some ten times as much memory."""


def json_values(payload: bytes | memoryview) -> dict[str, Any]:
    """The values of a message by name; a message that is no object has one, `value`.

    Raises:
        RosMessageError: It is no JSON, or too long.
    """
    if len(payload) > MOST_JSON:
        text = f"it has {len(payload)} bytes of JSON, and {MOST_JSON} are read"
        raise RosMessageError(text)
    try:
        found = json.loads(bytes(payload), parse_int=_number)
    except (ValueError, RecursionError) as error:
        text = f"it is no JSON: {error}"
        raise RosMessageError(text) from error
    return found if isinstance(found, dict) else {"value": found}


def _number(text: str) -> int | float:
    return int(text) if len(text) < 20 else float(text)
