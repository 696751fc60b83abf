"""The structure that an enclosure rides on: its modes, what moves them, several dampers on it."""
