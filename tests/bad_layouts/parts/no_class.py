"""Offers a number."""

VISUALIZERS = {"visualizeNothing": 1}
