"""The capabilities a robot can have: finer than modules, one kind of action or data each."""

from __future__ import annotations

import enum


class Capability(enum.StrEnum):
    """What a module can do or provide.

    Attributes:
        CON_REAL: Real-time control: keep-alives and screen updates of a console.
        VIS_VID: Pictures of the robot's main camera, on request.
        VIS_PTZ: Pan, tilt and zoom of that camera.
        NAV_STATE: The robot's state: pose, velocities, range sensors, bumpers, battery.
        NAV_MOVE: Motion by velocity commands.
        PRO_MAP: A map made from range sensors and odometry.
        DRV_BASE: The hardware's side of navigation: wheels and raw sensors.
        SIM_TRUTH: The simulator's ground truth.
    """

    CON_REAL = "CON_REAL"
    VIS_VID = "VIS_VID"
    VIS_PTZ = "VIS_PTZ"
    NAV_STATE = "NAV_STATE"
    NAV_MOVE = "NAV_MOVE"
    PRO_MAP = "PRO_MAP"
    DRV_BASE = "DRV_BASE"
    SIM_TRUTH = "SIM_TRUTH"
