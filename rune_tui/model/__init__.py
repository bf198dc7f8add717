"""The state of the console and its robots, and the geometry between picture and world."""
