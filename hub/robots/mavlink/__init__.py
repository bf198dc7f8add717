"""Robots with an autopilot that uses MAVLink, such as ArduPilot or PX4."""
