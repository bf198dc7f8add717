"""The right that each control message to central needs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hub.errors import NotAllowedError
from hub.ipc.definition import Plane
from hub.ipc.roles import Action, Principal, demand, may
from hub.ipc.security.publish_rights import demand_right
from hub.ipc.wire import control

_ASKED = {
    control.Subscribe: Action.SUBSCRIBE,
    control.Handle: Action.ANSWER,
    control.Last: Action.QUERY,
    control.Query: Action.QUERY,
    control.Watch: Action.PRESENCE,
    control.Close: Action.CLOSE_MODULE,
    control.LogLevel: Action.SET_LOG_LEVEL,
}
_NAMED = (control.Define, control.Advertise, control.Subscribe, control.Close)


def check(
    principal: Principal, client: str, message: Any, plane: Callable[[str], str | None]
) -> None:
    """Refuse a control message that its sender may not send.

    Args:
        principal: Holder of the sender's key.
        client: The sender's name at central.
        message: The control message.
        plane: The plane of a message, by name; None: it is not defined.

    Raises:
        NotAllowedError: The text names the missing right, and the role that has it.
    """
    if isinstance(message, control.Define):
        _check_definition(principal, message.name, plane)
        return
    if isinstance(message, (control.Query, control.Advertise)):
        known = plane(message.name)
        publishes = isinstance(message, control.Advertise) and known is not None
        if known is not None and (publishes or known == Plane.COMMAND.value):
            demand_right(principal, client, message.name, known)
    demand(principal, _ASKED.get(type(message), Action.LIST))


def _check_definition(principal: Principal, name: str, plane: Callable[[str], str | None]) -> None:
    if plane(name) is None and not may(principal.role, Action.DEFINE):
        # A stronger key is no remedy: a module of the robot defines it.
        text = (
            f"{principal.name} has a key to {principal.role.value} and may not define a new "
            f"message: no module of this robot has defined {name[:80]} yet; start the module that "
            "uses it"
        )
        raise NotAllowedError(text)


def refusal(message: Any, text: str) -> Any:
    """The answer to a forbidden control message; None: it has none."""
    if isinstance(message, (control.Query, control.Last)):
        return control.Failure(number=message.number, error="HandlerFailedError", text=text)
    if isinstance(message, _NAMED):
        error = NotAllowedError.__name__
        return control.Refused(subject=message.name, error=error, text=text)
    return None
