"""A hub in Foxglove and Lichtblick: its messages as they are, and standard topics of ROS 2."""
