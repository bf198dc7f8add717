"""Why a robot cannot execute an order: it has no module for it."""

from __future__ import annotations

from hub.gcm.providers import TAKEN_BY
from rune_tui.model.robot_state import LackKind, RobotState


def why_unsupported(robot: RobotState, message: str, *, lasting: bool = False) -> str:
    """Why no module of the robot accepts a message, in a sentence; empty if one may.

    Args:
        robot: The robot.
        message: The message's name.
        lasting: Whether a module that is about to start counts.
    """
    takers = TAKEN_BY.get(message, ())
    lacks = [robot.link.lacking.get(taker) for taker in takers]
    if not lacks or lacks[0] is None or None in lacks:
        return ""
    if lasting and any(lack is not None and lack.kind is LackKind.COMING for lack in lacks):
        return ""
    return f"it does not provide {takers[0]}: {lacks[0].why}"
