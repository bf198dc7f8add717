"""A simulated autopilot with MAVLink: rover, Sub and blimp as ArduPilot 4.7 drives them."""
