"""What simulated cameras see: rays, light, textures, noise, and the head that turns them."""
