"""Contact parameters from a measured discharge or efficiency, by simulation: the inverse fit."""
