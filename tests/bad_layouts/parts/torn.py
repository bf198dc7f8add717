"""Is no Python."""

class
