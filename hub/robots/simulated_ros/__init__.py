"""A simulated robot with ROS behind a bridge for Foxglove: wheels in an arena."""
