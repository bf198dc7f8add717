"""Questionnaires in the terminal: TOML files of items, answers that survive a kill, screens."""
