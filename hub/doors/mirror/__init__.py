"""A console's side of a fleet: for each robot there is, a local hub that stands for the robot's."""
