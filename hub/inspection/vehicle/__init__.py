"""The commands of `rune-hub` about vehicles with an autopilot."""
