"""Sessions: the journal, the steps of a participant, trials with hub and console."""
