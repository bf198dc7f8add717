"""Ways into central for others than clients of this machine."""
