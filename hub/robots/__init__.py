"""The robots: what hardware each kind has, and how to reach it."""
