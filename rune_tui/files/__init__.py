"""Files that the console writes in the user's folders."""
