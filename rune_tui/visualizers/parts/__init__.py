"""Parts of several visualizers: rows of words, bars, notices, the fading of stale values."""
