"""The module that records what is published on the robot's hub."""
