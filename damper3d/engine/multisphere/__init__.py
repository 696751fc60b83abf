"""Specialisations for particles of many spheres: pairs, walls, rotation, growth, contact models."""
