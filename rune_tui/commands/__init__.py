"""What the commands of rune do, besides the console."""
