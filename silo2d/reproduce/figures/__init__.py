"""Figures of the tables: a module each."""
