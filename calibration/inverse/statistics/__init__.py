"""Statistics of the inverse fit, from prior to posterior and identifiability, of any simulator."""
