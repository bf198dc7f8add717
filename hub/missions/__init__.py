"""What a robot keeps of a mission: the journal of its marks, its maps, its track, its pictures."""
