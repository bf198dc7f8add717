"""Gauges and curves of single values."""
