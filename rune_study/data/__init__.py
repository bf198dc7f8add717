"""The data of a study as tables: trials, metrics, events, and a dictionary of their columns."""
