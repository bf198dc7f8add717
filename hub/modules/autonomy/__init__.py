"""The robot's own will, under the operator: explores, goes, returns, wanders, holds."""
