"""The rights to publish: one table by message and role; pure.

A client checks them before it publishes. Central checks them when a client asks to publish, or to
query on the command plane. The gateway checks every command from another machine.
"""

from __future__ import annotations

from collections.abc import Mapping

from hub.errors import NotAllowedError
from hub.ipc.definition import Plane
from hub.ipc.roles import Principal, Role
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Right:
    """The conditions to publish a message, or to query with it.

    Attributes:
        role: The least role of a key.
        module: The only module with this right; empty: any client of that role.
        unordered: Whether it passes even with a wrong header. Only a stop does.
    """

    role: Role
    module: str = ""
    unordered: bool = False


_OPERATOR = Right(role=Role.OPERATE)
_SUPERVISOR = Right(role=Role.SUPERVISE)
_MODULE = Right(role=Role.MODULE)

COMMANDS: Mapping[str, Right] = {
    # Every client may stop the robot.
    "GCM_Stop": Right(role=Role.OBSERVE, unordered=True),
    # Commands of operators. `hub.control_gate` checks which operator has control.
    "GCM_Velocity_Command": _OPERATOR,
    "GCM_Goal_Command": _OPERATOR,
    "GCM_Turn_Command": _OPERATOR,
    "GCM_Assistance_Command": _OPERATOR,
    "GCM_Landmark_Correction": _OPERATOR,
    "GCM_Camera_Command": _OPERATOR,
    "GCM_Night_Command": _OPERATOR,
    "GCM_Vehicle_Command": _OPERATOR,
    "GCM_Mavlink_Request": _OPERATOR,
    "GCM_Point_Command": _OPERATOR,
    "GCM_Map_Command": _OPERATOR,
    "GCM_Mission_Command": _OPERATOR,
    "GCM_Autonomy_Command": _OPERATOR,
    "GCM_Record_Command": _OPERATOR,
    "GCM_Capability_Wants": _OPERATOR,
    "GCM_Common_RequestData": _OPERATOR,
    "GCM_Console_Heartbeat": _OPERATOR,
    # Two of its actions need `supervise`; `hub.robomon.control_service` checks them.
    "GCM_Control_Request": _OPERATOR,
    "GCM_Pad_Device": _OPERATOR,
    "GCM_Pad_State": _OPERATOR,
    "GCM_Pad_Console": _OPERATOR,
    # The start and end of the robot's modules, and the time of simulations.
    "SIM_Pause": _SUPERVISOR,
    "GCM_Common_Command": _SUPERVISOR,
    "GCM_Module_Command": _SUPERVISOR,
    # Wheel commands. The driver checks the sender again.
    "GCM_Drive_Command": Right(role=Role.MODULE, module="navigation"),
    "GCM_Drive_Goal": Right(role=Role.MODULE, module="navigation"),
}
"""All messages of GCM on the command plane."""

ROBOMON = "robomon"
"""The name of the hub's daemon at central; only its connection reports the owner of control."""
ROBOT_NAMES: frozenset[str] = frozenset(
    {ROBOMON, "driver", "navigation", "vision", "mapping", "autonomy", "recorder"}
)
"""Names that are reserved for the robot's own modules, even while they do not run."""


def right(message: str, plane: str) -> Right:
    """The right to publish a message that is defined on this plane.

    A command that is not in the table is for operators: a module of the robot defined it.
    States and pictures come from the robot's own modules.
    """
    known = COMMANDS.get(message)
    if known is None:
        return _OPERATOR if plane == Plane.COMMAND.value else _MODULE
    return known


def may_publish(role: Role, message: str, plane: str = Plane.COMMAND.value) -> bool:
    """Whether a role may publish a message."""
    return role.includes(right(message, plane).role)


def demand_right(principal: Principal, client: str, message: str, plane: str) -> None:
    """Check the right of a principal and its client to publish a message.

    Args:
        principal: Holder of the key.
        client: The client's name at central.
        message: The message's name.
        plane: The message's plane.

    Raises:
        NotAllowedError: It is missing; the text names the least role that has it.
    """
    needed = right(message, plane)
    if not principal.role.includes(needed.role):
        text = f"{principal.name} has a key to {principal.role.value} and may not send {message}; "
        if needed.role is Role.MODULE:
            text += f"only {_publishers(needed)} sends it"
        else:
            text += f"that needs a key made with --role {needed.role.value}"
    elif needed.module not in ("", client):
        text = f"{client} may not send {message}; only {_publishers(needed)} sends it"
    else:
        return
    raise NotAllowedError(text)


def reserved_text(name: str, principal: Principal) -> str:
    """Why a key cannot connect under a name of the robot's modules."""
    return (
        f"{name!r} is the name of a module of the robot, and {principal.name} has a key to "
        f"{principal.role.value}; connect under another name"
    )


def _publishers(needed: Right) -> str:
    return f"the robot's module {needed.module}" if needed.module else "a module of the robot"
