"""Sockets, their loop, and common parts of clients and the broker."""
