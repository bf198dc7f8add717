"""The seam to the hardware: wheels, range sensors, bumpers, battery."""
