"""The daemon that runs central and the robot's modules."""
