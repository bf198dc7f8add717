"""What a robot of a fleet says of itself, as JSON from outside; pure."""

from __future__ import annotations

import json
from typing import Any

from hub.errors import FrameError, HubError
from hub.gcm.catalog import BY_NAME
from hub.ipc.definition import MessageDefinition
from hub.ipc.wire import control
from hub.ipc.wire.definition_listing import from_listing

_LONGEST = 1 << 20
_MOST = 4096
_TEXTS = ("name", "format", "fields", "keep", "plane")
_MOST_DIGITS = 10
"""Those of the largest session."""


def read_definitions(payload: bytes) -> tuple[MessageDefinition[Any] | control.Define, ...]:
    """The messages of a robot's hub: those of GCM, and others as they are listed.

    Those that are no listing are left out. To make a definition of a listing takes some
    milliseconds: `definition_of` does it for one.

    Raises:
        FrameError: It is no list of messages.
    """
    said = _json(payload)
    if not isinstance(said, list) or len(said) > _MOST:
        text = "the definitions of a robot are no list of messages"
        raise FrameError(text)
    return tuple(found for each in said if (found := _listed(each)) is not None)


def definition_of(listing: control.Define) -> MessageDefinition[Any] | None:
    """The definition that a robot lists; None: it cannot be read."""
    try:
        return from_listing(listing)
    except (HubError, TypeError, ValueError):
        return None


def read_operators(payload: bytes, operator: str) -> dict[int, int]:
    """The number at the robot's hub of each session of one operator that it knows.

    Args:
        payload: The robot's table of sessions.
        operator: The operator, such as "operate:alice".

    Raises:
        FrameError: It is none of that.
    """
    said = _json(payload)
    if not isinstance(said, dict) or len(said) > _MOST:
        text = "the operators of a robot are no table of sessions"
        raise FrameError(text)
    return {
        int(session): number
        for place, number in said.items()
        for owner, _, session in [place.rpartition("/")]
        if owner == operator
        if session.isdecimal() and len(session) <= _MOST_DIGITS
        if isinstance(number, int) and 0 < number < 1 << 32
    }


def _listed(said: object) -> MessageDefinition[Any] | control.Define | None:
    if not isinstance(said, dict) or not all(isinstance(said.get(key), str) for key in _TEXTS):
        return None
    known = BY_NAME.get(said["name"])
    if known is not None and known.wire_format == said["format"]:
        return known
    try:
        return control.Define(
            **{key: said[key] for key in _TEXTS},
            rate_hz=float(said.get("rate_hz", 0.0)),
            lifespan_s=float(said.get("lifespan_s", "inf")),
        )
    except (TypeError, ValueError, OverflowError):
        return None


def _json(payload: bytes) -> Any:  # noqa: ANN401 - JSON of others
    if len(payload) > _LONGEST:
        text = f"{len(payload)} bytes of JSON are too many"
        raise FrameError(text)
    try:
        return json.loads(payload)
    except (ValueError, RecursionError) as error:
        text = "what a robot says of itself is no JSON"
        raise FrameError(text) from error
