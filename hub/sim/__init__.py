"""The simulator: arenas, ray casting, kinematics and sensors, in numpy alone."""
