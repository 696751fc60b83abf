"""Figures and films of a run, drawn from its folder."""
