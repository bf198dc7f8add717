"""Keys, and what each role may publish and ask for."""
