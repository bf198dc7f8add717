"""What records a running hub: its messages as they come, files in series, snapshots."""
