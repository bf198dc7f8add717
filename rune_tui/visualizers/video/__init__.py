"""The camera's picture and what is drawn into it."""
