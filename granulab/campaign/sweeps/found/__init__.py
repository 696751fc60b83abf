"""Runs that a sweep finds: those that its journal lists, and who made the others."""
