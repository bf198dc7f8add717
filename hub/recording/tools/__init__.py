"""What `rune-hub log` does with recordings: facts, copies of parts, tables, recovery."""
