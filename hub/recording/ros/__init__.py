"""What others record: messages of ROS and Foxglove by their definition, folders of rosbag2."""
