"""Robots with ROS 1 or ROS 2: the line to them, their body, their cameras."""
