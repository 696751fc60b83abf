"""Random packing fractions of particles of any shape, computed and shaken."""
