"""Slow tests of a bed in two half containers: shear and compression (thesis, sec. 8.5.1.2)."""
