"""Makes, serves and saves the occupancy grid and the interest points."""
