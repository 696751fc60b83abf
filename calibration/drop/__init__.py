"""A drop test: from the track of a bouncing thing to restitution, speeds, scale and rate."""
