"""Effective field: the bed as a mass that varies with frequency and amplitude; responses."""
