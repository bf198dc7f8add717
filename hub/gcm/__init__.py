"""The vocabulary that all modules and consoles share; pure, no sockets."""
