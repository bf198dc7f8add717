"""The commands of rune, except the console."""
