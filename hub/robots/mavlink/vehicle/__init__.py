"""One vehicle: a state machine with a clock, what it measures, what it is asked; pure."""
