"""The parts of a client: its connection, publishers, subscriptions and queries."""
