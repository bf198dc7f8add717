"""The camera's picture and overlays on it."""
