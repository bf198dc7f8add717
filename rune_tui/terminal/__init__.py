"""The operator's terminal: its answers, its abilities, and its speed."""
