"""Offers a list."""

VISUALIZERS = ["visualizeNothing"]
