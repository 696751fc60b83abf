"""Bodies that are rigid clusters of spheres: their state, motion, lists and contacts."""
