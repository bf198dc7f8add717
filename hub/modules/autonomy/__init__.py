"""Autonomy, below the operator: explores, goes, returns, wanders, holds."""
