"""A joystick at another machine: both ends of the line to it."""
