"""Single values as gauges and curves."""
