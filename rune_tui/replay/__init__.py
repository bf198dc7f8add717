"""Shows recordings: states of robots from files, drawn by the console's own renderer."""
