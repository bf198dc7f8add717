"""Goals for the navigation that a robot with ROS has itself: Nav2, or move_base."""
