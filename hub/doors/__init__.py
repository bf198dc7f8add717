"""Programs that join a hub with systems of others as its clients, one process each."""
