"""Sockets, the loop that serves them, and what clients and the broker both need around them."""
