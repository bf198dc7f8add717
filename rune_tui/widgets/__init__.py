"""Rune widgets: control events to effects."""
