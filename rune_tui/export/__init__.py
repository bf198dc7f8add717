"""Files that operators take home: what was marked, and where."""
