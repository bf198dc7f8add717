"""A hub among nodes of ROS 2: they see its robot as a node, over Zenoh."""
