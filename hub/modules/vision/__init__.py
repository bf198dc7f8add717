"""Pictures on request and the pan/tilt/zoom camera."""
