"""Rooms of the studio: what the page asks of each simulator, of runs, drawings and measurements."""
