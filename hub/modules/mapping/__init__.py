"""Occupancy grid and interest points: made, answered for, saved."""
