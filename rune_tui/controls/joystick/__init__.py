"""From reports of devices to controls of layouts: shaping, matching, calibration; pure."""
