"""How densely particles of any shape pack at random, and the numbers that are shipped of it."""
