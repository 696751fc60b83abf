"""Discharge of a silo from video: times, curve, displacement profile of the layers, velocities."""
