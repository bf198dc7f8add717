"""A line to a robot whose nodes meet over Zenoh (rmw_zenoh)."""
