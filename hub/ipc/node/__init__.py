"""A client from within: its connection, publishers, subscriptions and queries."""
