"""The hub: what runs on the robot, headless."""
