"""Devices of this machine: which there are, and the threads that read them."""
