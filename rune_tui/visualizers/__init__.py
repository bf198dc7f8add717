"""One visualizer a file: a kind of message to a picture."""
