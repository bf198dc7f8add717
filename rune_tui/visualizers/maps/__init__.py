"""The map, what is marked on it, and the ranges around the robot."""
