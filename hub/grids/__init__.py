"""Grid maps as arrays: clearance, path planning, reachable ground, frontiers; pure."""
