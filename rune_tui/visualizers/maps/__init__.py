"""The map with its marks, and the ranges around the robot."""
