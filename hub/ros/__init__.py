"""Messages of ROS and Foxglove, read by their definition; pure."""
