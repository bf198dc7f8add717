"""What panels see as parameters: facts about the robot, read-only; pure."""

from __future__ import annotations

import math

from hub.gcm.body import Freedom, RobotBody


def parameters_of(body: RobotBody, *, drive: bool) -> dict[str, str | float | bool]:
    """The facts that panels may want; what is not known is left out.

    Args:
        body: Of the robot.
        drive: Whether panels may drive it.
    """
    facts: dict[str, str | float | bool] = {
        "robot.name": body.name,
        "robot.kind": body.kind,
        "robot.radius_m": body.radius,
        "robot.height_m": body.height,
        "robot.mass_kg": body.mass,
        "robot.left_alone": body.left_alone,
        "door.drive": drive,
    }
    for motion in body.motions:
        unit = "rad_per_s" if motion.freedom >= Freedom.ROLL else "m_per_s"
        facts[f"limit.{motion.freedom.name.lower()}_{unit}"] = motion.limit
    return {
        name: value
        for name, value in facts.items()
        if not (isinstance(value, float) and math.isnan(value))
    }
