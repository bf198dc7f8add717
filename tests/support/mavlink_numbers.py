"""Numbers of MAVLink and of ArduPilot's modes that tests write by their names."""

ROVER, SUB, BLIMP = 10, 12, 7
"""MAV_TYPE of vehicles."""
GUIDED, HOLD, MANUAL, ACRO = 15, 4, 0, 1
"""Modes of a rover."""
DEPTH_HOLD, POSITION_HOLD, SUB_GUIDED, SURFACE, SUB_MANUAL = 2, 16, 4, 9, 19
"""Modes of a Sub."""
BLIMP_VELOCITY, BLIMP_LOITER, BLIMP_MANUAL = 2, 3, 1
"""Modes of a blimp."""
SET_MODE, ARM, INTERVAL, RESTART = 176, 400, 511, 246
"""Commands: MAV_CMD_DO_SET_MODE, COMPONENT_ARM_DISARM, SET_MESSAGE_INTERVAL,
PREFLIGHT_REBOOT_SHUTDOWN."""
