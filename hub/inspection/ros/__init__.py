"""What the commands about robots with ROS do."""
