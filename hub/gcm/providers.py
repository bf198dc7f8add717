"""The capabilities that publish each message, and those that receive it."""

from __future__ import annotations

from collections.abc import Mapping

from hub.gcm import (
    autonomy,
    autopilot,
    battery,
    camera_info,
    diagnostics,
    edges,
    environment,
    flight,
    imu,
    joints,
    mapping,
    mission,
    navigation,
    own_navigation,
    ranges,
    recording,
    simulation,
    transforms,
    vehicle,
    vision,
)
from hub.gcm.capability import Capability

PROVIDED_BY: Mapping[str, tuple[Capability, ...]] = {
    navigation.ROBOT_STATE.name: (Capability.NAV_STATE,),
    battery.BATTERY.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    imu.IMU.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    flight.ALTITUDE.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    flight.FLUID_PRESSURE.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    navigation.NAVIGATION_STATUS.name: (
        Capability.NAV_STATE,
        Capability.NAV_MOVE,
        Capability.NAV_GOAL,
    ),
    navigation.DRIVE_COMMAND.name: (Capability.NAV_MOVE, Capability.NAV_GOAL),
    own_navigation.DRIVE_GOAL.name: (Capability.NAV_GOAL,),
    own_navigation.OWN_NAVIGATION.name: (Capability.DRV_BASE,),
    navigation.DRIVE_STATE.name: (Capability.DRV_BASE,),
    ranges.RANGES.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    diagnostics.DIAGNOSTICS.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    edges.EDGES.name: (Capability.NAV_STATE,),
    environment.ENVIRONMENT.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    vehicle.VEHICLE_STATE.name: (Capability.DRV_BASE, Capability.NAV_STATE),
    autopilot.AUTOPILOT_STATE.name: (Capability.DRV_MODE,),
    autopilot.AUTOPILOT_TEXT.name: (Capability.DRV_MODE,),
    autopilot.MAVLINK_FRAMES.name: (Capability.DRV_MODE,),
    joints.JOINT_STATES.name: (Capability.DRV_JOINT,),
    navigation.GROUND_TRUTH.name: (Capability.SIM_TRUTH,),
    transforms.TRANSFORMS.name: (Capability.NAV_STATE,),
    vision.IMAGE.name: (Capability.VIS_VID,),
    camera_info.CAMERA_INFO.name: (Capability.VIS_VID,),
    vision.CAMERA_STATE.name: (Capability.VIS_PTZ, Capability.VIS_VID, Capability.VIS_NIGHT),
    mapping.MAP.name: (Capability.PRO_MAP,),
    mapping.INTEREST_POINTS.name: (Capability.PRO_POINTS,),
    mapping.POINT_REFUSAL.name: (Capability.PRO_POINTS,),
    mission.MISSION_STATE.name: (Capability.PRO_POINTS,),
    autonomy.AUTONOMY_STATE.name: (Capability.AUT_PILOT,),
    recording.RECORD_MARK.name: (Capability.REC_LOG,),
    recording.RECORD_STATE.name: (Capability.REC_LOG,),
}
"""The capabilities that bring a message, by its name; the nearest first.

Navigation needs the driver, so it brings what the driver publishes.
"""

TAKEN_BY: Mapping[str, tuple[Capability, ...]] = {
    navigation.VELOCITY_COMMAND.name: (Capability.NAV_MOVE,),
    navigation.STOP.name: (
        Capability.NAV_MOVE,
        Capability.NAV_GOAL,
        Capability.NAV_STATE,
        Capability.AUT_PILOT,
    ),
    navigation.GOAL_COMMAND.name: (Capability.NAV_GOAL,),
    navigation.TURN_COMMAND.name: (Capability.NAV_GOAL,),
    navigation.ASSISTANCE_COMMAND.name: (Capability.NAV_MOVE,),
    navigation.LANDMARK_CORRECTION.name: (Capability.NAV_STATE,),
    navigation.DRIVE_COMMAND.name: (Capability.DRV_BASE,),
    own_navigation.DRIVE_GOAL.name: (Capability.DRV_BASE,),
    simulation.SIMULATION_PAUSE.name: (Capability.SIM_TRUTH,),
    vehicle.VEHICLE_COMMAND.name: (
        Capability.DRV_HOLD,
        Capability.DRV_LIGHT,
        Capability.DRV_JOINT,
        Capability.DRV_ARM,
        Capability.DRV_MODE,
    ),
    autopilot.MAVLINK_REQUEST.name: (Capability.DRV_MODE,),
    vision.IMAGE_REQUEST.name: (Capability.VIS_VID,),
    vision.CAMERA_COMMAND.name: (Capability.VIS_PTZ,),
    vision.NIGHT_COMMAND.name: (Capability.VIS_NIGHT,),
    mapping.MAP_REQUEST.name: (Capability.PRO_MAP,),
    mapping.MAP_COMMAND.name: (Capability.PRO_MAP,),
    mapping.POINT_COMMAND.name: (Capability.PRO_POINTS,),
    mission.MISSION_COMMAND.name: (Capability.PRO_POINTS,),
    autonomy.AUTONOMY_COMMAND.name: (Capability.AUT_PILOT,),
    recording.RECORD_COMMAND.name: (Capability.REC_LOG,),
}
"""The capabilities that receive a message, by its name; the nearest first."""
