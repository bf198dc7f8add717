"""Rough ground: height maps of test elements, and how bodies on wheels or tracks stand on them."""
