"""What the console opens first: layouts, and their changes on disk."""
