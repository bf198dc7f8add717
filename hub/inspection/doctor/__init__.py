"""The checks of rune-hub doctor."""
