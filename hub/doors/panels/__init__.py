"""The side of the hub in doors for panels: they show topics and may drive; nodes are panels too."""
