"""Storage of missions: the journal of marks, the maps, the track, the pictures."""
