"""Granular dampers in space: particles in a shaken enclosure and the energy they dissipate."""
