"""Impacts of a bouncing body in force, acceleration or sound (thesis, sec. 7.3)."""
