"""Visualizers, one per file: each draws one kind of message."""
