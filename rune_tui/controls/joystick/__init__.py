"""From what devices report to what layouts name: shaping, matching, calibration; pure."""
