"""Frames of messages, and the control messages of the bus; pure."""
