"""Statistics of measurements: uncertainty, robust fits, correlated noise."""
