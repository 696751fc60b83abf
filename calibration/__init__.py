"""Measurements to contact parameters: videos, tables and signals to values with uncertainty."""
