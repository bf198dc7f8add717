"""Fails."""

raise RuntimeError("the file\n\x1b[2J is broken")
