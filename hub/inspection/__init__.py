"""Looking into a running hub: what `rune-hub list`, `echo`, `rate`, `send` and `query` do."""
