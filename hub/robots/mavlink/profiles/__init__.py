"""What differs between vehicles: a table per autopilot and type; pure."""
