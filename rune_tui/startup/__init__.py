"""Opens layouts and follows their changes on disk."""
