"""Files with the results of a run: marks, pages and recordings."""
