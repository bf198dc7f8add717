"""Operators that are models, whose interaction time and neglect tolerance are known."""
