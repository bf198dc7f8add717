"""The capabilities of a robot: each is one kind of action or data."""

from __future__ import annotations

import enum

from hub.values import dataclass


class Capability(enum.StrEnum):
    """One kind of action or data of a module.

    Attributes:
        CON_REAL: Real-time control: keep-alives and screen updates of a console.
        VIS_VID: Pictures of the robot's main camera, on request.
        VIS_PTZ: Pan, tilt and zoom of that camera.
        VIS_NIGHT: Pictures in the dark: gain, and the headlight where there is one.
        NAV_STATE: The robot's state: pose, velocities, range sensors, bumpers, battery.
        NAV_MOVE: Motion by velocity commands.
        NAV_GOAL: Motion to points: go, follow waypoints, turn by an angle.
        PRO_MAP: A map made from range sensors and odometry.
        PRO_POINTS: Interest points on the map: victims and landmarks.
        AUT_PILOT: Autonomy: explore, wander, return, go, hold.
        DRV_BASE: The hardware's side of navigation: wheels and raw sensors.
        DRV_HOLD: Holds of height, depth, heading or position.
        DRV_LIGHT: Lights that can be switched.
        DRV_JOINT: Joints that the operator moves, such as flippers.
        DRV_ARM: Motors that can be armed and disarmed.
        DRV_MODE: Modes of an autopilot that the operator may ask for.
        REC_LOG: Recordings of what is published.
        SIM_TRUTH: The simulator's ground truth.
    """

    CON_REAL = "CON_REAL"
    VIS_VID = "VIS_VID"
    VIS_PTZ = "VIS_PTZ"
    VIS_NIGHT = "VIS_NIGHT"
    NAV_STATE = "NAV_STATE"
    NAV_MOVE = "NAV_MOVE"
    NAV_GOAL = "NAV_GOAL"
    PRO_MAP = "PRO_MAP"
    PRO_POINTS = "PRO_POINTS"
    AUT_PILOT = "AUT_PILOT"
    DRV_BASE = "DRV_BASE"
    DRV_HOLD = "DRV_HOLD"
    DRV_LIGHT = "DRV_LIGHT"
    DRV_JOINT = "DRV_JOINT"
    DRV_ARM = "DRV_ARM"
    DRV_MODE = "DRV_MODE"
    REC_LOG = "REC_LOG"
    SIM_TRUTH = "SIM_TRUTH"


@dataclass(frozen=True, slots=True, kw_only=True)
class Abilities:
    """The capabilities of a module on a given robot, and its needs.

    Attributes:
        provides: Its capabilities.
        needs: Capabilities of other modules that it cannot work without.
    """

    provides: tuple[Capability, ...]
    needs: tuple[Capability, ...] = ()
