"""`rune-hub control`: shows the owner of control, and frees the robot."""

from __future__ import annotations

from hub.command_output import put, put_json
from hub.errors import HubError
from hub.gcm.autonomy import DrivingMode
from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import (
    CONTROL_REQUEST,
    CONTROL_STATE,
    WARNED_S,
    ControlAction,
    ControlRequest,
    ControlState,
)
from hub.inspection import value_text
from hub.inspection.module_commands import ask_daemon, last_report
from hub.inspection.output import report, span
from hub.ipc.client import Client
from hub.plain_text import plain


def show(client: Client, *, as_json: bool) -> int:
    """Show the owner of control, the requests for it, and the sender that moves the robot."""
    state = last_report(client, CONTROL_STATE)
    if as_json:
        put_json(value_text.plain(state))
        return 0
    for line in _lines(state):
        put(plain(line))
    return 0


def release(client: Client, *, force: bool) -> int:
    """Free the robot: its owner loses control, and requests are dropped.

    Raises:
        HubError: The daemon refused it.
    """
    if not force:
        text = "this takes control from whoever has it; if you stand by the robot, add --force"
        raise HubError(text)
    request = ControlRequest(action=ControlAction.FREE)
    return report(ask_daemon(client, CONTROL_REQUEST, request, COMMON_RESULT))


def _lines(state: ControlState) -> list[str]:
    lines = ["nobody has control"]
    if state.owner:
        held = span(state.held_s)
        lines = [f"{state.operator} ({state.owner_name}) has had control for {held}"]
        if state.silent_s >= WARNED_S:
            lines.append(f"{state.operator}'s console has been silent for {state.silent_s:.1f} s")
    if state.asker:
        more = f"; {state.waiting} more wait" if state.waiting else ""
        asker = f"{state.asker_operator} ({state.asker_name})"
        lines.append(f"{asker} asks for it, {state.left_s:.0f} s left to answer{more}")
    moved = state.commander is not DrivingMode.NOBODY
    lines.append(f"{state.commander_name} moves the robot" if moved else "nobody moves the robot")
    return [*lines, f"last: {state.why}"]
