"""The message bus, the counterpart of CMU IPC; it knows no robot."""
