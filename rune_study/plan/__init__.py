"""Studies on paper: the file of a study, orders of conditions, the plan of each participant."""
