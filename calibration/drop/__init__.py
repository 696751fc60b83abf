"""A drop test: from the track of a bouncing object to restitution, speeds, scale and rate."""
