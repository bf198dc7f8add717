"""What the console knows, and the geometry between picture and world."""
