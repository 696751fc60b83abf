"""Beds and outlets: forms of particles and their sizes, inserts, outlets, gates, plates."""
