"""Robot state and motion; the module that stops the robot when commands stop."""
