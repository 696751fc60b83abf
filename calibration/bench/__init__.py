"""Measurements at the bench, from tables: friction, damping, stiffness, roughness, density."""
