"""Commands that inspect a running hub: `rune-hub list`, `echo`, `rate`, `send` and `query`."""
