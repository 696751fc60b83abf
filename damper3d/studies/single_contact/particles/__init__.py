"""One multi-sphere particle that is pressed on a wall, hits it, or moves freely."""
