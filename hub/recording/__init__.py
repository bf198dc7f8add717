"""Recordings: MCAP files of what was published; a crash costs at most half a second of them."""
