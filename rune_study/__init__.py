"""The laboratory: studies that compare ways to drive robots, on people and on models of people."""
