"""Parts of a robot file that the tests of vehicles share."""

PARTS = """
[[light]]
name = "lamp"
[[joint]]
name = "camera"
lowest_deg = -45
highest_deg = 45
[[range]]
name = "ahead"
kind = "sonar"
farthest = 5.0
"""
