"""Keys and devices to control events."""
