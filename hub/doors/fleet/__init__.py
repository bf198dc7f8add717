"""A robot's gateway to its fleet: a client of the hub beside it, and of a Zenoh router."""
