"""Quantities that several measures take from the contacts and particles of a run."""
