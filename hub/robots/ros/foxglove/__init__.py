"""The line to a robot with ROS by a bridge for Foxglove."""
