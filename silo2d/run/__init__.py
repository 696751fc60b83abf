"""Runs of silos: filling, opening and discharge, with checkpoints; one, or many."""
