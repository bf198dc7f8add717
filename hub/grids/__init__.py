"""Grid maps as arrays: what is near, which way leads somewhere, where the map ends; pure."""
