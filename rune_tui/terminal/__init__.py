"""What is known of the operator's terminal: its answers, how far it has got, what it takes."""
