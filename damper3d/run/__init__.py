"""Runs of dampers: filling and shaking, with checkpoints; one, or many."""
