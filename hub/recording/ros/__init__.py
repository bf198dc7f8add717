"""What others record: folders and databases of rosbag2, and the robot in their topics."""
