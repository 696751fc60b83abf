"""Measures of a run: efficiency, response, and the phases of motion, from its records."""
