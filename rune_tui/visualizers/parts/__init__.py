"""What several visualizers are made of: rows of words, bars, notices, the look of stale values."""
