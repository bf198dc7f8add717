"""The connection to each robot's hub."""
