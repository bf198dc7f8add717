"""What others record: messages of any ROS 2 type by their definition, folders of rosbag2."""
