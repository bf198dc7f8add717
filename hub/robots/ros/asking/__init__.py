"""Questions to a robot with ROS without driving it: its topics, what it says, what stops it."""
