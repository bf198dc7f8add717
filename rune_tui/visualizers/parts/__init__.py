"""Parts that visualizers share: rows of words, notices, history, staleness."""
