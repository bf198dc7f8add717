"""Textual: the screen, its panes and bars."""
