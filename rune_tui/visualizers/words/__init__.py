"""Visualizers that write rows of words."""
