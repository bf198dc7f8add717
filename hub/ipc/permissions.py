"""What a client has to be allowed to do to say something to central."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hub.errors import NotAllowedError
from hub.ipc import control
from hub.ipc.definition import Plane
from hub.ipc.security import Action

_ASKED = {
    control.Subscribe: Action.SUBSCRIBE,
    control.Handle: Action.ANSWER,
    control.Last: Action.QUERY,
    control.Watch: Action.PRESENCE,
    control.Close: Action.CLOSE_MODULE,
    control.LogLevel: Action.SET_LOG_LEVEL,
}
_NAMED = (control.Define, control.Advertise, control.Subscribe, control.Close)


def asked(message: Any, plane: Callable[[str], str | None]) -> Action:
    """The action that a control message asks for.

    Args:
        message: The control message.
        plane: The plane of the message of a name; None if it is not defined.
    """
    if isinstance(message, control.Define):
        return Action.LIST if plane(message.name) else Action.DEFINE
    if isinstance(message, control.Query):
        return Action.QUERY_COMMAND if _is_command(message, plane) else Action.QUERY
    if isinstance(message, control.Advertise) and plane(message.name):
        return Action.PUBLISH_COMMAND if _is_command(message, plane) else Action.PUBLISH_STATE
    return _ASKED.get(type(message), Action.LIST)


def refusal(message: Any, text: str) -> Any:
    """What the sender of a control message that is not allowed is told; None if nothing."""
    if isinstance(message, (control.Query, control.Last)):
        return control.Failure(number=message.number, error="HandlerFailedError", text=text)
    if isinstance(message, _NAMED):
        error = NotAllowedError.__name__
        return control.Refused(subject=message.name, error=error, text=text)
    return None


def _is_command(
    message: control.Query | control.Advertise, plane: Callable[[str], str | None]
) -> bool:
    return plane(message.name) == Plane.COMMAND.value
